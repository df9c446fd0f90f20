// SPDX-License-Identifier: Apache-2.0
// Leaves of an octree in depth-first order, addressed by Morton code; shared by reading, writing
// and merging of octrees.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/dense/octree_io.h"

namespace nightmap {

// Begins the line of a `.ot`, a comment for OctoMap, that ends with the hash of all below it.
constexpr std::string_view kOctreeHashLine = "# xxh3 of all below: ";

struct PlacedLeaf {
  std::uint64_t code = 0;  // Morton code of its first voxel
  float log_odds = 0;
  Rgb rgb = kNoColor;
  std::uint8_t height = 0;  // 0: the smallest voxel

  bool Occupied() const { return IsOccupied(log_odds); }
};

OccupancyVoxel ToVoxel(const PlacedLeaf& leaf, double resolution_m);

// The tree's leaves in depth-first order. Throws DataError beginning with `name` when one does not
// fit OctoMap's grid or is not finite.
std::vector<PlacedLeaf> PlaceLeaves(const OccupancyTree& tree, const std::string& name);

// A source that visits leaves depth first, as often as needed.
struct LeafSource {
  double resolution_m = 0;
  std::function<void(const std::function<void(const PlacedLeaf&)>&)> visit;
};

LeafSource LeavesOfTree(const OccupancyTree& tree);

// Collects leaves that come depth first. Merges eight equal free leaves without a color into one,
// at every level, so that the same space gives the same leaves however it was cut.
class LeafList {
 public:
  void Append(const PlacedLeaf& leaf);
  const std::vector<PlacedLeaf>& Leaves() const { return leaves_; }
  OccupancyTree Tree(double resolution_m) const;

 private:
  bool EndsWithEightEqual() const;

  std::vector<PlacedLeaf> leaves_;
};

}  // namespace nightmap
