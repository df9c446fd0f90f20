// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/octree_leaves.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

PlacedLeaf Place(const OccupancyVoxel& leaf, double resolution_m, const std::string& name) {
  const double height = std::log2(leaf.size_m / resolution_m);
  const bool valid_size =
      height > -0.01 && std::abs(height - std::round(height)) < 0.01 && height < 15.5;
  if (!valid_size || !std::isfinite(leaf.log_odds) ||
      !(leaf.centre_in_map.cwiseAbs().maxCoeff() < OctreeReach_m(resolution_m))) {
    throw DataError("{}: a leaf at ({}, {}, {}) of size {} m does not fit an octree of {} m",
                    name,
                    leaf.centre_in_map.x(),
                    leaf.centre_in_map.y(),
                    leaf.centre_in_map.z(),
                    leaf.size_m,
                    resolution_m);
  }
  const int levels = static_cast<int>(std::lround(height));
  const std::uint64_t code = MortonCode(VoxelOf(leaf.centre_in_map, resolution_m));
  return {
      code >> 3 * levels << 3 * levels, leaf.log_odds, leaf.rgb, static_cast<std::uint8_t>(levels)};
}

}  // namespace

OccupancyVoxel ToVoxel(const PlacedLeaf& leaf, double resolution_m) {
  const VoxelKey first = KeyOfMortonCode(leaf.code);
  const VoxelKey cube(first.x() >> leaf.height, first.y() >> leaf.height, first.z() >> leaf.height);
  const double size_m = resolution_m * (1 << leaf.height);
  return {VoxelCentre(cube, size_m), size_m, leaf.log_odds, leaf.rgb};
}

std::vector<PlacedLeaf> PlaceLeaves(const OccupancyTree& tree, const std::string& name) {
  if (!(tree.resolution_m > 0)) {
    throw DataError("{}: the octree's resolution must be positive", name);
  }
  std::vector<PlacedLeaf> leaves;
  leaves.reserve(tree.leaves.size());
  for (const OccupancyVoxel& leaf : tree.leaves) {
    leaves.push_back(Place(leaf, tree.resolution_m, name));
  }
  if (!std::ranges::is_sorted(leaves, {}, &PlacedLeaf::code)) {
    std::ranges::stable_sort(leaves, {}, &PlacedLeaf::code);
  }
  return leaves;
}

void LeafList::Append(const PlacedLeaf& leaf) {
  leaves_.push_back(leaf);
  while (EndsWithEightEqual()) {
    leaves_.erase(leaves_.end() - 7, leaves_.end());
    ++leaves_.back().height;
  }
}

bool LeafList::EndsWithEightEqual() const {
  if (leaves_.size() < 8) return false;
  const PlacedLeaf& last = leaves_.back();
  const bool is_eighth = (last.code >> 3 * last.height & 7) == 7;
  if (!is_eighth || last.Occupied() || last.height + 1 >= kOctreeDepth) return false;
  return std::all_of(leaves_.end() - 8, leaves_.end(), [&](const PlacedLeaf& leaf) {
    return leaf.code >> 3 * (last.height + 1) == last.code >> 3 * (last.height + 1) &&
           leaf.height == last.height && leaf.log_odds == last.log_odds && leaf.rgb == kNoColor;
  });
}

OccupancyTree LeafList::Tree(double resolution_m) const {
  OccupancyTree tree;
  tree.resolution_m = resolution_m;
  tree.leaves.reserve(leaves_.size());
  for (const PlacedLeaf& leaf : leaves_) {
    tree.leaves.push_back(ToVoxel(leaf, resolution_m));
  }
  return tree;
}

LeafSource LeavesOfTree(const OccupancyTree& tree) {
  return {tree.resolution_m, [leaves = PlaceLeaves(tree, "octree")](const auto& visit) {
            for (const PlacedLeaf& leaf : leaves) visit(leaf);
          }};
}

}  // namespace nightmap
