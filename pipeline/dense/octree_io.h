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

// The one rule of what is occupied: log-odds from 0 on. It is OctoMap's default, probability 0.5,
// so its tools find the same in the same file.
constexpr bool IsOccupied(float log_odds) { return log_odds >= 0; }

using Rgb = std::array<std::uint8_t, 3>;
constexpr Rgb kNoColor{255, 255, 255};  // none measured

// One leaf: a cube of known space. Space without a leaf is unknown.
struct OccupancyVoxel {
  Eigen::Vector3d centre_in_map = Eigen::Vector3d::Zero();
  double size_m = 0;   // edge; resolution times a power of two
  float log_odds = 0;  // of occupancy, less those of the threshold
  Rgb rgb = kNoColor;

  bool Occupied() const { return IsOccupied(log_odds); }
};

// Voxel edges lie on integer multiples of the resolution; leaves do not overlap.
struct OccupancyTree {
  double resolution_m = 0;             // edge of the smallest leaf
  std::vector<OccupancyVoxel> leaves;  // in any order; as read: depth first
};

// Distance from the origin that a tree reaches along each axis.
double OctreeReach_m(double resolution_m);

// Writes `.ot`: log-odds and colors, the bytes that OctoMap's own ColorOcTree of these leaves would
// write after pruning at every level (its prune() ends at the first level with nothing to merge),
// and a comment with their hash.
// Merges eight equal leaves to one (with their mean color), so a tree read back may hold fewer,
// larger leaves. Fast for leaves that come depth first. Throws DataError naming the file.
void WriteOctree(const std::filesystem::path& path, const OccupancyTree& tree);

// Writes `.bt`: only occupied or free (maximum likelihood). Throws DataError naming the file.
void WriteBinaryOctree(const std::filesystem::path& path, const OccupancyTree& tree);

// Counts in voxels of the smallest size.
struct VoxelCounts {
  std::size_t num_occupied = 0;
  std::size_t num_free = 0;

  void Add(int height, bool occupied) {
    (occupied ? num_occupied : num_free) += std::size_t{1} << 3 * height;
  }
};

// Writes the `.ot` and `.bt` of the union of disjoint trees in files: the bytes that WriteOctree
// and WriteBinaryOctree give for the whole, provided that occupied leaves have a color and free
// ones none, or none has. Memory holds the output and one leaf per part. Throws DataError naming
// the file when one cannot be read or written, when resolutions differ or leaves overlap.
VoxelCounts MergeOctrees(const std::vector<std::filesystem::path>& parts,
                         const std::filesystem::path& ot,
                         const std::filesystem::path& bt);

// Reads an `.ot`. Throws DataError as OctreeReader.
OccupancyTree ReadOctree(const std::filesystem::path& path);

}  // namespace nightmap
