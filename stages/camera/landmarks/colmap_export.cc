// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/colmap_export.h"

#include <utility>

#include "pipeline/io/resize_picture.h"

namespace nightmap {
namespace {

ColmapImage MakeImage(const LandmarksInput& input,
                      DescriptorKind kind,
                      const MapKeyframe& keyframe) {
  const auto frame_idx =
      static_cast<std::size_t>(keyframe.frame_idx - input.frames.front().frame_idx);
  const FrameRecord& frame = input.frames[frame_idx];
  const SiteFeatures::Frame features = input.features.GetFrame(keyframe.frame_idx);
  ColmapImage image;
  image.name = frame.color.path;
  image.camera_idx = frame.camera_idx;
  image.camera_from_map = keyframe.map_from_camera.Inverse();
  const RgbdCamera& camera = input.cameras[static_cast<std::size_t>(frame.camera_idx)];
  const Camera picture = camera.Picture();
  for (const Eigen::Vector2f& pixel : features->raw_keypoints_px) {
    image.keypoints_px.push_back(ResizePixel(pixel.cast<double>(), camera.color, picture));
  }
  image.keypoint_points.assign(image.keypoints_px.size(), -1);
  if (kind == DescriptorKind::kRootSift) image.descriptors = features->descriptors;
  return image;
}

// The landmark with its observations by keyframes.
ColmapPoint MakePoint(const LandmarkMap& map, std::size_t landmark, const ColmapModel& model) {
  ColmapPoint point;
  point.position_in_map = map.positions_in_map[landmark];
  for (std::size_t i = 0; i < map.landmark_keyframes[landmark].size(); ++i) {
    const ColmapObservation seen{map.landmark_keyframes[landmark][i],
                                 map.landmark_features[landmark][i]};
    const ColmapImage& image = model.images[static_cast<std::size_t>(seen.image_idx)];
    const Camera& camera = model.cameras[static_cast<std::size_t>(image.camera_idx)];
    const auto pixel = camera.Project(image.camera_from_map * point.position_in_map);
    if (!pixel) continue;
    point.error_px += (*pixel - image.keypoints_px[static_cast<std::size_t>(seen.keypoint)]).norm();
    point.track.push_back(seen);
  }
  if (!point.track.empty()) point.error_px /= static_cast<double>(point.track.size());
  return point;
}

}  // namespace

ColmapModel MakeColmapModel(const LandmarksInput& input, const LandmarkMap& map) {
  ColmapModel model;
  for (const RgbdCamera& camera : input.cameras) model.cameras.push_back(camera.Picture());
  for (const MapKeyframe& keyframe : map.keyframes) {
    model.images.push_back(MakeImage(input, map.kind, keyframe));
  }
  for (std::size_t i = 0; i < map.positions_in_map.size(); ++i) {
    ColmapPoint point = MakePoint(map, i, model);
    if (point.track.size() < 2) continue;
    for (const ColmapObservation& seen : point.track) {
      model.images[static_cast<std::size_t>(seen.image_idx)]
          .keypoint_points[static_cast<std::size_t>(seen.keypoint)] =
          static_cast<int>(model.points.size());
    }
    model.points.push_back(std::move(point));
  }
  return model;
}

}  // namespace nightmap
