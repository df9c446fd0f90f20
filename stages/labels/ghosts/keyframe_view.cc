// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/ghosts/keyframe_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/labels/labelled_regions.h"

namespace nightmap {
namespace {

constexpr int kNumBlocks = 80;  // along a row

// Calls use(x, y) for the pixels of a block.
template <typename Use>
void ForBlock(const DepthImage& depth, int block_px, int block_x, int block_y, const Use& use) {
  for (int y = block_y * block_px; y < std::min((block_y + 1) * block_px, depth.height); ++y) {
    for (int x = block_x * block_px; x < std::min((block_x + 1) * block_px, depth.width); ++x) {
      use(x, y);
    }
  }
}

// 0 when less than half of the block is measured.
float NearestOfBlock(const DepthImage& depth, int block_px, int block_x, int block_y) {
  float nearest_m = std::numeric_limits<float>::max();
  int num_measured = 0, num_pixels = 0;
  ForBlock(depth, block_px, block_x, block_y, [&](int x, int y) {
    const float depth_m = depth.At(x, y);
    ++num_pixels;
    if (depth_m <= 0) return;
    ++num_measured;
    nearest_m = std::min(nearest_m, depth_m);
  });
  return 2 * num_measured < num_pixels ? 0 : nearest_m;
}

// Depth of the nearest surface in a block and those around it; none where most of one is not
// measured.
std::optional<double> NearestAround_m(const KeyframeView& view, int at_x, int at_y) {
  std::uint16_t nearest_mm = std::numeric_limits<std::uint16_t>::max();
  for (int y = std::max(at_y - 1, 0); y <= std::min(at_y + 1, view.nearest_mm.height - 1); ++y) {
    for (int x = std::max(at_x - 1, 0); x <= std::min(at_x + 1, view.nearest_mm.width - 1); ++x) {
      nearest_mm = std::min(nearest_mm, view.nearest_mm.At(x, y));
    }
  }
  if (nearest_mm == 0) return std::nullopt;
  return 1e-3 * nearest_mm;
}

}  // namespace

KeyframeView MakeKeyframeView(const Keyframe& keyframe,
                              const RgbdCamera& camera,
                              const DepthImage& depth,
                              const GrayImage& may_move) {
  const bool is_labelled = !may_move.pixels.empty();
  if (is_labelled && (may_move.width != depth.width || may_move.height != depth.height)) {
    throw DataError("a mask of {} x {} pixels for depth of {} x {}",
                    may_move.width,
                    may_move.height,
                    depth.width,
                    depth.height);
  }
  KeyframeView view;
  view.keyframe = &keyframe;
  view.camera = &camera;
  view.camera_from_map = keyframe.map_from_camera.Inverse();
  view.block_px = std::max(1, depth.width / kNumBlocks);
  const int width = (depth.width + view.block_px - 1) / view.block_px;
  const int height = (depth.height + view.block_px - 1) / view.block_px;
  view.nearest_mm = {width, height, 1, {}};
  DepthImage small_depth{width, height, 1, {}};
  GrayImage small_may_move{width, height, 1, {}};
  const auto centre = [&](int block, int size) {
    return std::min(block * view.block_px + view.block_px / 2, size - 1);
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float nearest_m = NearestOfBlock(depth, view.block_px, x, y);
      view.nearest_mm.pixels.push_back(
          static_cast<std::uint16_t>(std::clamp(1000 * nearest_m, 0.0F, 65535.0F)));
      small_depth.pixels.push_back(nearest_m);
      const bool moves =
          is_labelled && may_move.At(centre(x, depth.width), centre(y, depth.height)) != 0;
      small_may_move.pixels.push_back(moves && nearest_m > 0 ? 255 : 0);
    }
  }
  LabelledRegions regions = FindLabelledRegions(small_may_move, small_depth);
  view.points.resize(static_cast<std::size_t>(regions.num));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int region = regions.of_pixel.At(x, y);
      if (region == 0) continue;
      const Eigen::Vector2d pixel(centre(x, depth.width), centre(y, depth.height));
      view.points[static_cast<std::size_t>(region - 1)].push_back(
          keyframe.map_from_camera * camera.color.BackProject(pixel, small_depth.At(x, y)));
    }
  }
  view.region = std::move(regions.of_pixel);
  return view;
}

bool MaySee(const KeyframeView& view, const Eigen::Vector3d& centre_in_map, double radius_m) {
  const Eigen::Vector3d in_camera = view.camera_from_map * centre_in_map;
  return in_camera.z() > -radius_m && in_camera.norm() < view.camera->max_depth_m + radius_m;
}

bool SeesThrough(const KeyframeView& view,
                 const RegionPoints& points,
                 double min_share,
                 double min_difference_m,
                 double num_sigmas) {
  std::size_t num_seen = 0, num_through = 0;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d in_camera = view.camera_from_map * point;
    const auto pixel = view.camera->color.Project(in_camera);
    if (!pixel || !view.camera->color.Contains(*pixel)) continue;
    const auto nearest_m = NearestAround_m(view,
                                           static_cast<int>(pixel->x()) / view.block_px,
                                           static_cast<int>(pixel->y()) / view.block_px);
    const double margin_m = min_difference_m + num_sigmas * std::numbers::sqrt2 *
                                                   view.camera->noise.Sigma_m(in_camera.z());
    if (!nearest_m || *nearest_m < in_camera.z() - margin_m) continue;
    ++num_seen;
    num_through += *nearest_m > in_camera.z() + margin_m;
  }
  return 3 * num_seen >= points.size() &&
         static_cast<double>(num_through) >= min_share * static_cast<double>(num_seen);
}

}  // namespace nightmap
