// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/columns.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "pipeline/base/error.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

constexpr int kMaxSide = 32767;     // cells
constexpr double kRounding = 1e-9;  // of a height in voxels, so that 0.1 / 0.04 is 2.5

// A leaf in units of smallest voxels.
struct Block {
  int x = 0, y = 0, z = 0, size = 1;
  bool occupied = false;
};

Block ToBlock(const PlacedLeaf& leaf) {
  const VoxelKey key = KeyOfMortonCode(leaf.code);
  return {key.x(), key.y(), key.z(), 1 << leaf.height, leaf.Occupied()};
}

// Bounding box of the leaves; there is one.
Area BoundingArea(const LeafSource& leaves) {
  int min_x = kMaxSide, min_y = kMaxSide, max_x = -kMaxSide, max_y = -kMaxSide;
  leaves.visit([&](const PlacedLeaf& leaf) {
    const Block block = ToBlock(leaf);
    min_x = std::min(min_x, block.x);
    min_y = std::min(min_y, block.y);
    max_x = std::max(max_x, block.x + block.size);
    max_y = std::max(max_y, block.y + block.size);
  });
  if (max_x < min_x) throw DataError("the octree is empty: check the octree stage's report");
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

// Likewise for every column of every leaf, with the run that the leaf adds to that column.
template <typename Visit>
void ForRuns(const LeafSource& leaves, const Area& area, const Visit& visit) {
  leaves.visit([&](const PlacedLeaf& leaf) {
    const Block block = ToBlock(leaf);
    const ColumnRun run{block.z, block.z + block.size, block.occupied};
    ForColumns(block, area, [&](std::size_t column) { visit(column, run); });
  });
}

bool GoesOn(const ColumnRun& run, const ColumnRun& above) {
  return above.begin == run.end && above.occupied == run.occupied;
}

// Number of runs of each column, after a leading zero.
std::vector<std::size_t> CountRuns(const LeafSource& leaves, const Area& area) {
  std::vector<std::size_t> counts(area.Size() + 1, 0);
  std::vector<ColumnRun> last(area.Size(), ColumnRun{0, std::numeric_limits<int>::min(), false});
  ForRuns(leaves, area, [&](std::size_t column, const ColumnRun& run) {
    if (!GoesOn(last[column], run)) ++counts[column + 1];
    last[column] = run;
  });
  return counts;
}

}  // namespace

HeightRange VoxelsWithin(double min_m, double max_m, double resolution_m) {
  return {static_cast<int>(std::ceil(min_m / resolution_m - 0.5 - kRounding)),
          static_cast<int>(std::floor(max_m / resolution_m - 0.5 + kRounding))};
}

Columns CollectColumns(const LeafSource& leaves, Progress& progress) {
  progress.Start(3);
  Columns columns{BoundingArea(leaves), leaves.resolution_m, {}, {}};
  progress.Advance(1);
  columns.first = CountRuns(leaves, columns.area);
  std::partial_sum(columns.first.begin(), columns.first.end(), columns.first.begin());
  progress.Advance(1);
  columns.runs.resize(columns.first.back());
  std::vector<std::uint32_t> num_runs(columns.area.Size(), 0);
  ForRuns(leaves, columns.area, [&](std::size_t column, const ColumnRun& run) {
    ColumnRun* end = &columns.runs[columns.first[column]] + num_runs[column];
    if (num_runs[column] > 0 && GoesOn(end[-1], run)) {
      end[-1].end = run.end;
    } else {
      *end = run;
      ++num_runs[column];
    }
  });
  progress.Advance(1);
  progress.Finish();
  return columns;
}

}  // namespace nightmap
