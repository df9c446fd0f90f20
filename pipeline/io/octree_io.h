// SPDX-License-Identifier: Apache-2.0
// Occupancy octrees as lists of leaves, in OctoMap's file formats (Hornung et al., OctoMap: an
// efficient probabilistic 3D mapping framework based on octrees, Autonomous Robots 2013).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace nightmap {

constexpr int kOctreeDepth = 16;  // levels of OctoMap's trees

// One leaf: a cube of known space. What no leaf covers is unknown.
struct OccupancyVoxel {
  Eigen::Vector3d centre_in_map = Eigen::Vector3d::Zero();
  double size_m = 0;                               // edge; resolution times a power of two
  float log_odds = 0;                              // of being occupied
  std::array<std::uint8_t, 3> rgb{255, 255, 255};  // white: no color measured

  // OctoMap's default threshold, probability 0.5, which its tools apply to the same file.
  bool Occupied() const { return log_odds >= 0; }
};

// Voxel edges lie on integer multiples of the resolution; leaves do not overlap.
struct OccupancyTree {
  double resolution_m = 0;             // edge of the smallest leaf
  std::vector<OccupancyVoxel> leaves;  // in any order; as read: depth first
};

// How far from the origin a tree reaches along each axis.
double OctreeReach_m(double resolution_m);

// `.ot`: log-odds and colors, the bytes that OctoMap's own ColorOcTree of these leaves would write
// once pruned at every level (its prune() ends at the first with nothing to merge). Eight equal
// leaves are merged to one (their colors averaged), so a tree read back may hold fewer, larger
// leaves. Fast for leaves that come depth first. Throws DataError naming the file.
void WriteOctree(const std::filesystem::path& path, const OccupancyTree& tree);

// `.bt`: only occupied or free (maximum likelihood). Throws DataError naming the file.
void WriteBinaryOctree(const std::filesystem::path& path, const OccupancyTree& tree);

// Voxels of the smallest size.
struct VoxelCounts {
  std::size_t num_occupied = 0;
  std::size_t num_free = 0;

  void Add(int height, bool occupied) {
    (occupied ? num_occupied : num_free) += std::size_t{1} << 3 * height;
  }
};

// Writes the `.ot` and `.bt` of the tree that files of parts, which share no space, make together:
// the bytes that WriteOctree and WriteBinaryOctree give for the whole, provided that occupied
// leaves have a color and free ones none, or none has. Holds what it writes in memory, and of each
// part a leaf. Throws DataError naming the file when one cannot be read or written, when
// resolutions differ or leaves overlap.
VoxelCounts MergeOctrees(const std::vector<std::filesystem::path>& parts,
                         const std::filesystem::path& ot,
                         const std::filesystem::path& bt);

// Reads an `.ot` of type ColorOcTree or OcTree (white leaves). Throws DataError naming the file
// when it is truncated, of another type, or holds NaN.
OccupancyTree ReadOctree(const std::filesystem::path& path);

}  // namespace nightmap
