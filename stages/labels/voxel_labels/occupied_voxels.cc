// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/voxel_labels/occupied_voxels.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/dense/octree_reader.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

void CheckFits(const PlacedLeaf& leaf,
               double resolution_m,
               const Rectangle& around,
               const std::filesystem::path& path) {
  const double size_m = ToVoxel(leaf, resolution_m).size_m;
  if (size_m <= (around.max_m - around.min_m).maxCoeff() + resolution_m) return;
  throw DataError("{}: an occupied leaf of {} m is larger than a tile; make the octree again",
                  path.string(),
                  size_m);
}

}  // namespace

OccupiedVoxels ReadOccupiedVoxels(const std::filesystem::path& own,
                                  const std::vector<std::filesystem::path>& near,
                                  const Rectangle& around) {
  OccupiedVoxels occupied{OctreeReader(own).Resolution_m(), {}, {}};
  const auto read = [&](const std::filesystem::path& path, const auto& take) {
    OctreeReader reader(path);
    while (const auto leaf = reader.Next()) {
      if (!leaf->Occupied()) continue;
      CheckFits(*leaf, reader.Resolution_m(), around, path);
      const std::uint64_t num_voxels = std::uint64_t{1} << 3 * leaf->height;
      for (std::uint64_t i = 0; i < num_voxels; ++i) take(leaf->code + i);
    }
  };
  read(own, [&](std::uint64_t code) { occupied.own.push_back(code); });
  occupied.codes = occupied.own;
  for (const auto& path : near) {
    read(path, [&](std::uint64_t code) {
      const auto centre = VoxelCentre(KeyOfMortonCode(code), occupied.resolution_m);
      if (around.Contains(centre.head<2>())) occupied.codes.push_back(code);
    });
  }
  std::ranges::sort(occupied.codes);
  const auto rest = std::unique(occupied.codes.begin(), occupied.codes.end());  // `own` may be near
  occupied.codes.erase(rest, occupied.codes.end());
  return occupied;
}

}  // namespace nightmap
