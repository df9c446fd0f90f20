// SPDX-License-Identifier: Apache-2.0
#include "stages/grid/columns.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"

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

void AddFree(const Block& block, const Band& band, int num_free, Column& column) {
  if (num_free == 0) return;
  column.num_free = static_cast<std::uint16_t>(column.num_free + num_free);
  column.lowest_free = std::min(column.lowest_free, std::max(block.z, band.free.min));
  column.highest_free =
      std::max(column.highest_free, std::min(block.z + block.size - 1, band.free.max));
}

void AddBlock(const Block& block, const Band& band, Columns& columns) {
  const int num_in_band = band.obstacles.Overlap(block.z, block.size);
  const int num_free = band.free.Overlap(block.z, block.size);
  const bool floor = band.floor.Overlap(block.z, block.size) > 0;
  for (int y = block.y - columns.area.min_y; y < block.y - columns.area.min_y + block.size; ++y) {
    for (int x = block.x - columns.area.min_x; x < block.x - columns.area.min_x + block.size; ++x) {
      Column& column = columns.columns[columns.Index(x, y)];
      if (block.occupied) {
        column.num_occupied = static_cast<std::uint16_t>(column.num_occupied + num_in_band);
        column.floor |= floor;
      } else {
        AddFree(block, band, num_free, column);
      }
    }
  }
}

std::vector<Block> BlocksOfInterest(const OccupancyTree& tree, const Band& band) {
  std::vector<Block> blocks;
  for (const OccupancyVoxel& leaf : tree.leaves) {
    const Block block = ToBlock(leaf, tree.resolution_m);
    const bool use = block.occupied ? band.obstacles.Overlap(block.z, block.size) > 0 ||
                                          band.floor.Overlap(block.z, block.size) > 0
                                    : band.free.Overlap(block.z, block.size) > 0;
    if (use) blocks.push_back(block);
  }
  return blocks;
}

}  // namespace

Band MakeBand(double min_height_m, double max_height_m, double resolution_m) {
  const int first = static_cast<int>(std::ceil(min_height_m / resolution_m - 0.5 - kRounding));
  const int last = static_cast<int>(std::floor(max_height_m / resolution_m - 0.5 + kRounding));
  if (last < first) {
    throw UsageError(
        "obstacle_min_height_m {} to obstacle_max_height_m {} holds no centre of a {} m voxel: "
        "widen the band",
        min_height_m,
        max_height_m,
        resolution_m);
  }
  const HeightRange obstacles{first, last};
  return {{-obstacles.min, obstacles.min - 1}, obstacles, {0, last}};
}

Columns CollectColumns(const OccupancyTree& tree, const Band& band, Progress& progress) {
  const std::vector<Block> blocks = BlocksOfInterest(tree, band);
  if (blocks.empty()) {
    throw DataError(
        "the octree holds nothing between the floor (z = 0) and the top of the obstacle band: "
        "check that the map is upright");
  }
  Columns columns{BoundingArea(blocks), {}};
  columns.columns.resize(columns.Index(0, columns.area.height));
  progress.Start(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    AddBlock(blocks[i], band, columns);
    if ((i + 1) % kProgressStep == 0) progress.Advance(kProgressStep);
  }
  progress.Advance(blocks.size() % kProgressStep);
  progress.Finish();
  return columns;
}

}  // namespace nightmap
