// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/tiles/tiles.h"

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "stages/dense/tiles/view_footprint.h"

namespace nightmap {
namespace {

constexpr int kMaxIndex = 100'000;
// Distance to a seen point over its depth: 87 degrees off the axis, more than lenses of the camera
// model have, and few enough tiles to try each.
constexpr double kMaxSlant = 20;

// Neighbours compute their common border identically, to the last bit.
MapRegion RegionOf(const TilesOptions& options, const TileIndex& index) {
  const auto border_m = [&](int i) { return (i - 0.5) * options.edge_m; };
  return {{{border_m(index.first), border_m(index.second)},
           {border_m(index.first + 1), border_m(index.second + 1)}},
          options.overlap_m,
          options.max_range_m};
}

TileIndex TileOf(const TilesOptions& options, const Eigen::Vector2d& point) {
  const auto index = [&](double value_m) {
    return static_cast<int>(std::floor(value_m / options.edge_m + 0.5));
  };
  return {index(point.x()), index(point.y())};
}

void CheckPose(const TilesOptions& options, const Keyframe& keyframe) {
  const double distance_m = keyframe.map_from_camera.translation.cwiseAbs().maxCoeff();
  if (distance_m < kMaxIndex * options.edge_m) return;
  throw InputError(
      {{"keyframes"}},
      "keyframe {} is {} m from the origin of the map; if it was imported, correct the "
      "trajectory",
      keyframe.keyframe_idx,
      distance_m);
}

// Farthest that the camera sees at `max_range_m`, m from its center.
double Reach(const TilesOptions& options, const RgbdCamera& camera, const ViewPyramid& pyramid) {
  double reach_m = 0;
  for (const Eigen::Vector3d& corner : pyramid) {
    if (!(corner.norm() <= kMaxSlant * options.max_range_m)) {
      throw InputError(
          {{"cameras"}},
          "camera '{}' sees a point {} m off to the side at a depth of {} m, as no camera does; "
          "correct its focal length, center and distortion in the site config",
          camera.camera_id,
          corner.head<2>().norm(),
          options.max_range_m);
    }
    reach_m = std::max(reach_m, corner.norm());
  }
  return reach_m;
}

}  // namespace

std::string TileName(const TileIndex& index) {
  return fmt::format("{}_{}", index.first, index.second);
}

std::map<TileIndex, Tile> RunTiles(const TilesOptions& options,
                                   const std::vector<RgbdCamera>& cameras,
                                   const std::vector<Keyframe>& keyframes) {
  std::vector<ViewPyramid> pyramids;
  std::vector<int> reaches;  // in tiles in each direction, counted from the camera's own
  for (const RgbdCamera& camera : cameras) {
    pyramids.push_back(MakeViewPyramid(camera.color, options.max_range_m));
    const double reach_m = Reach(options, camera, pyramids.back()) + options.overlap_m;
    reaches.push_back(static_cast<int>(std::ceil(reach_m / options.edge_m)));
  }
  std::map<TileIndex, Tile> tiles;
  for (const Keyframe& keyframe : keyframes) {
    CheckPose(options, keyframe);
    const Rigid3& pose = keyframe.map_from_camera;
    const TileIndex own = TileOf(options, pose.translation.head<2>());
    const auto camera_idx = static_cast<std::size_t>(keyframe.frame.camera_idx);
    const ViewFootprint footprint = ProjectToMap(pyramids[camera_idx], pose);
    const int reach = reaches[camera_idx];
    const int width = 2 * reach + 1;
    for (int i = 0; i < width * width; ++i) {
      const TileIndex index{own.first + i / width - reach, own.second + i % width - reach};
      const MapRegion region = RegionOf(options, index);
      if (!Touches(footprint, region.inside.Grown(options.overlap_m))) continue;
      Tile& tile = tiles[index];
      tile.region = region;
      tile.keyframes.push_back(keyframe);
    }
  }
  return tiles;
}

}  // namespace nightmap
