// SPDX-License-Identifier: Apache-2.0
#include "stages/grid/columns.h"

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

constexpr int kMaxSide = 32767;     // cells
constexpr double kRounding = 1e-9;  // of a height in voxels, so that 0.1 / 0.04 is 2.5
constexpr std::size_t kProgressStep = 1 << 16;

// A leaf in units of smallest voxels.
struct Block {
  int x = 0, y = 0, z = 0, size = 1;
  bool occupied = false;
};

Block ToBlock(const OccupancyVoxel& leaf, double resolution_m) {
  const double size = std::round(leaf.size_m / resolution_m);
  const auto corner = [&](double centre_m) {
    return static_cast<int>(std::lround(centre_m / resolution_m - size / 2));
  };
  const Eigen::Vector3d& centre = leaf.centre_in_map;
  return {corner(centre.x()),
          corner(centre.y()),
          corner(centre.z()),
          static_cast<int>(size),
          leaf.Occupied()};
}

// Bounding box of the blocks; they are not empty.
Area BoundingArea(const std::vector<Block>& blocks) {
  int min_x = blocks[0].x, min_y = blocks[0].y, max_x = min_x, max_y = min_y;
  for (const Block& block : blocks) {
    min_x = std::min(min_x, block.x);
    min_y = std::min(min_y, block.y);
    max_x = std::max(max_x, block.x + block.size);
    max_y = std::max(max_y, block.y + block.size);
  }
  if (max_x - min_x > kMaxSide || max_y - min_y > kMaxSide) {
    throw DataError("the octree spans {} x {} cells, more than {}: use a coarser resolution",
                    max_x - min_x,
                    max_y - min_y,
                    kMaxSide);
  }
  return {min_x, min_y, max_x - min_x, max_y - min_y};
}

// Calls visit(column) for every column a block stands in.
template <typename Visit>
void ForColumns(const Block& block, const Area& area, const Visit& visit) {
  for (int y = block.y - area.min_y; y < block.y - area.min_y + block.size; ++y) {
    const std::size_t column = area.Index(block.x - area.min_x, y);
    for (std::size_t i = 0; i < static_cast<std::size_t>(block.size); ++i) visit(column + i);
  }
}

// Sorts a column's runs and joins those that touch; returns how many are left.
std::size_t JoinRuns(std::span<Run> runs) {
  std::ranges::sort(runs, {}, &Run::begin);
  std::size_t last = 0;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    if (runs[i].begin == runs[last].end && runs[i].occupied == runs[last].occupied) {
      runs[last].end = runs[i].end;
    } else {
      runs[++last] = runs[i];
    }
  }
  return runs.empty() ? 0 : last + 1;
}

}  // namespace

HeightRange VoxelsWithin(double min_m, double max_m, double resolution_m) {
  return {static_cast<int>(std::ceil(min_m / resolution_m - 0.5 - kRounding)),
          static_cast<int>(std::floor(max_m / resolution_m - 0.5 + kRounding))};
}

Columns CollectColumns(const OccupancyTree& tree, Progress& progress, int num_threads) {
  if (tree.leaves.empty()) throw DataError("the octree is empty: check the octree stage's report");
  std::vector<Block> blocks;
  blocks.reserve(tree.leaves.size());
  for (const OccupancyVoxel& leaf : tree.leaves) {
    blocks.push_back(ToBlock(leaf, tree.resolution_m));
  }
  Columns columns{BoundingArea(blocks), tree.resolution_m, {}, {}};
  const std::size_t num_columns = columns.area.Size();
  std::vector<std::size_t> next(num_columns + 1, 0);
  for (const Block& block : blocks) {
    ForColumns(block, columns.area, [&](std::size_t column) { ++next[column + 1]; });
  }
  for (std::size_t i = 0; i < num_columns; ++i) next[i + 1] += next[i];
  const std::vector<std::size_t> first = next;
  std::vector<Run> runs(first.back());
  progress.Start(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& block = blocks[i];
    ForColumns(block, columns.area, [&](std::size_t column) {
      runs[next[column]++] = {block.z, block.z + block.size, block.occupied};
    });
    if ((i + 1) % kProgressStep == 0) progress.Advance(kProgressStep);
  }
  progress.Advance(blocks.size() % kProgressStep);
  std::vector<std::size_t> num_runs(num_columns);
  ParallelFor(num_columns, num_threads, [&](std::size_t i) {
    num_runs[i] = JoinRuns(std::span(runs).subspan(first[i], first[i + 1] - first[i]));
  });
  columns.first.assign(1, 0);
  for (std::size_t i = 0; i < num_columns; ++i) {
    const auto begin = runs.begin() + static_cast<std::ptrdiff_t>(first[i]);
    columns.runs.insert(
        columns.runs.end(), begin, begin + static_cast<std::ptrdiff_t>(num_runs[i]));
    columns.first.push_back(columns.runs.size());
  }
  progress.Finish();
  return columns;
}

}  // namespace nightmap
