// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/octree_of_tiles.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

// A ray through a voxel of the tile may pass half a voxel beside the tile and end as far away as
// its range; a point two voxels farther may support its end.
double SupportReach_m(const OctreeOptions& options) {
  return options.max_range_m + 3 * options.resolution_m;
}

void CheckTile(const OctreeOptions& options, const MapRegion& region) {
  if (region.overlap_m < options.resolution_m / 2) {
    throw UsageError("tiles overlap by {} m, less than half a voxel of {} m; raise tiles.overlap_m",
                     region.overlap_m,
                     options.resolution_m);
  }
  const double edge_m = (region.inside.max_m - region.inside.min_m).minCoeff();
  if (edge_m < SupportReach_m(options)) {
    throw UsageError(
        "tiles of {} m are smaller than the {} m from which points support rays in them "
        "(max_range_m + 3 resolution_m); raise tiles.edge_m",
        edge_m,
        SupportReach_m(options));
  }
}

}  // namespace

VoxelBox VoxelsOf(const Rectangle& rectangle, double resolution_m) {
  constexpr int kReach = 1 << (kOctreeDepth - 1);
  const auto first = [resolution_m](double border_m) {
    const double voxel = std::ceil(border_m / resolution_m - 0.5);
    return static_cast<int>(std::clamp(voxel, -1.0 * kReach, 1.0 * kReach));
  };
  return {{first(rectangle.min_m.x()), first(rectangle.min_m.y()), -kReach},
          {first(rectangle.max_m.x()), first(rectangle.max_m.y()), kReach}};
}

std::vector<CloudPoint> ReadCloudAround(const std::vector<std::filesystem::path>& clouds,
                                        const Rectangle& tile,
                                        const OctreeOptions& options) {
  return ReadPlyWithin(clouds, tile.Grown(SupportReach_m(options)));
}

OctreeResult RunOctreeTile(const OctreeOptions& options,
                           const KeyframeSource& source,
                           const std::vector<CloudPoint>* cloud,
                           Progress& progress,
                           int num_threads) {
  CheckTile(options, source.region);
  const VoxelBox voxels = VoxelsOf(source.region.inside, options.resolution_m);
  return RunOctree(options, source, cloud, voxels, progress, num_threads);
}

}  // namespace nightmap
