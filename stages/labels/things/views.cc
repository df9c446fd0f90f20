// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/views.h"

#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

constexpr std::size_t kMaxSamples = 64;
constexpr double kMinSeenShare = 0.25;
constexpr double kMargin_voxels = 1.5;  // a surface that is seen at a slant hides itself otherwise

using Points = std::vector<Eigen::Vector3d>;

Points SamplesOf(const Points& points) {
  const std::size_t count = std::min(points.size(), kMaxSamples);
  Points samples;
  for (std::size_t i = 0; i < count; ++i) samples.push_back(points[i * points.size() / count]);
  return samples;
}

// The pixel of a point of the map, if it lies in the picture.
std::optional<Eigen::Vector2d> PixelOf(const Camera& camera, const Eigen::Vector3d& in_camera) {
  const auto pixel = camera.Project(in_camera);
  return pixel && camera.Contains(*pixel) ? pixel : std::nullopt;
}

double SeenShare(const LabelledSpace& space,
                 const Points& samples,
                 const Keyframe& keyframe,
                 const Camera& camera,
                 double max_range_m) {
  const Rigid3 camera_from_map = keyframe.map_from_camera.Inverse();
  const double margin_m = kMargin_voxels * space.Resolution_m();
  int num_seen = 0;
  for (const Eigen::Vector3d& sample : samples) {
    const Eigen::Vector3d in_camera = camera_from_map * sample;
    num_seen += in_camera.norm() <= max_range_m && PixelOf(camera, in_camera) &&
                space.IsClear(keyframe.map_from_camera.translation, sample, margin_m);
  }
  return num_seen / static_cast<double>(samples.size());
}

// Around the voxels of these centres that are in the picture, cut to it; at least one is in it.
std::array<int, 4> RectangleOf(const Points& points,
                               const Keyframe& keyframe,
                               const Camera& camera,
                               double resolution_m) {
  const Rigid3 camera_from_map = keyframe.map_from_camera.Inverse();
  Eigen::AlignedBox2d around;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d in_camera = camera_from_map * point;
    const auto pixel = PixelOf(camera, in_camera);
    if (!pixel) continue;
    const double half_px = std::max(camera.fx, camera.fy) * resolution_m / 2 / in_camera.z();
    around.extend(Eigen::Vector2d(pixel->array() - half_px));
    around.extend(Eigen::Vector2d(pixel->array() + half_px));
  }
  const auto clamped = [](double value, int max) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(max)));
  };
  // Pixel 0 reaches from -0.5 to 0.5.
  return {clamped(std::floor(around.min().x() + 0.5), camera.width),
          clamped(std::floor(around.min().y() + 0.5), camera.height),
          clamped(std::ceil(around.max().x() + 0.5), camera.width),
          clamped(std::ceil(around.max().y() + 0.5), camera.height)};
}

double Area_px2(const std::array<int, 4>& rectangle_px) {
  return 1.0 * (rectangle_px[2] - rectangle_px[0]) * (rectangle_px[3] - rectangle_px[1]);
}

// The rectangle in the picture as stored.
std::array<int, 4> InPicture(const std::array<int, 4>& rectangle_px, const RgbdCamera& camera) {
  const Camera picture = camera.Picture();
  const auto scaled = [](int edge, int from, int to) {
    return static_cast<int>(std::int64_t{edge} * to / from);
  };
  const auto& [left, top, right, bottom] = rectangle_px;
  return {scaled(left, camera.color.width, picture.width),
          scaled(top, camera.color.height, picture.height),
          scaled(right, camera.color.width, picture.width),
          scaled(bottom, camera.color.height, picture.height)};
}

}  // namespace

ThingViews FindViews(const LabelledSpace& space,
                     const Points& points_in_map,
                     const std::vector<Keyframe>& keyframes,
                     const std::vector<RgbdCamera>& cameras,
                     double max_range_m) {
  const Points samples = SamplesOf(points_in_map);
  Eigen::Vector3d middle(0, 0, 0);
  for (const Eigen::Vector3d& sample : samples)
    middle += sample / static_cast<double>(samples.size());
  ThingViews views;
  double best = 0;
  for (const Keyframe& keyframe : keyframes) {
    const Camera& camera = cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)].color;
    const double share = SeenShare(space, samples, keyframe, camera, max_range_m);
    if (share < kMinSeenShare) continue;
    ++views.num_views;
    const Eigen::Vector3d towards = keyframe.map_from_camera.translation - middle;
    views.direction_in_map += towards.head<2>().normalized();
    const auto rectangle_px = RectangleOf(points_in_map, keyframe, camera, space.Resolution_m());
    if (share * Area_px2(rectangle_px) <= best) continue;
    best = share * Area_px2(rectangle_px);
    views.best = {
        keyframe.frame.time_ns,
        keyframe.frame.color.path,
        InPicture(rectangle_px, cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)])};
  }
  return views;
}

}  // namespace nightmap
