// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/grid.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "stages/dense/grid/classify_cells.h"
#include "stages/dense/grid/columns.h"
#include "stages/dense/grid/floors.h"
#include "stages/dense/grid/ground.h"

namespace nightmap {
namespace {

// Rounds to a nanometre, so that multiples of the resolution print short in the YAML.
Eigen::Vector2d Rounded(const Eigen::Vector2d& point_m) {
  return (point_m * 1e9).array().round() / 1e9;
}

// The part of the grid with known cells and an unknown border around it. Empty when there is none.
OccupancyGrid CropToSeen(const OccupancyGrid& grid, double margin_m) {
  Eigen::Vector2i low(grid.width, grid.height);
  Eigen::Vector2i high(-1, -1);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (grid.At({x, y}) == kUnknownCell) continue;
      low = low.cwiseMin(Eigen::Vector2i(x, y));
      high = high.cwiseMax(Eigen::Vector2i(x, y));
    }
  }
  if (high.x() < 0) return {};
  const int margin = static_cast<int>(std::ceil(margin_m / grid.resolution_m));
  low.array() -= margin;
  high.array() += margin;
  OccupancyGrid crop;
  crop.width = high.x() - low.x() + 1;
  crop.height = high.y() - low.y() + 1;
  crop.resolution_m = grid.resolution_m;
  crop.origin_in_map = Rounded(grid.origin_in_map + grid.resolution_m * low.cast<double>());
  crop.cells.assign(crop.Index(0, crop.height), kUnknownCell);
  for (int y = 0; y < crop.height; ++y) {
    for (int x = 0; x < crop.width; ++x) {
      const Eigen::Vector2i source(x + low.x(), y + low.y());
      if (grid.Contains(source)) crop.cells[crop.Index(x, y)] = grid.At(source);
    }
  }
  return crop;
}

void CountCells(FloorGrid& floor) {
  const auto count = [&](CellValue value) {
    return static_cast<std::size_t>(std::ranges::count(floor.grid.cells, value));
  };
  floor.num_free_cells = count(kFreeCell);
  floor.num_occupied_cells = count(kOccupiedCell);
  floor.num_unknown_cells = count(kUnknownCell);
}

// Share of the occupied voxels below the lowest floor. A large share means that it is no floor.
double ShareBelow(const Columns& columns, double lowest_floor_m) {
  constexpr double kDepth_m = 0.3;
  const int end = VoxelsWithin(lowest_floor_m - kDepth_m, 0, columns.resolution_m).min;
  std::int64_t num_below = 0;
  std::int64_t num_occupied = 0;
  for (const ColumnRun& run : columns.runs) {
    if (!run.occupied) continue;
    num_occupied += run.end - run.begin;
    num_below += std::max(0, std::min(run.end, end) - run.begin);
  }
  return num_occupied == 0 ? 0 : static_cast<double>(num_below) / static_cast<double>(num_occupied);
}

void CheckBand(const GridOptions& options, double resolution_m) {
  const HeightRange band =
      VoxelsWithin(options.max_step_height_m, options.robot_height_m, resolution_m);
  if (band.max >= band.min) return;
  throw UsageError(
      "max_step_height_m {} to robot_height_m {} holds no centre of a {} m voxel: raise "
      "robot_height_m, or make the octree finer",
      options.max_step_height_m,
      options.robot_height_m,
      resolution_m);
}

}  // namespace

GridResult RunGrid(const GridOptions& options,
                   const LeafSource& leaves,
                   const std::vector<Eigen::Vector3d>& cameras_in_map,
                   Progress& progress,
                   int num_threads) {
  CheckBand(options, leaves.resolution_m);
  const Columns columns = CollectColumns(leaves, progress);
  const Supports supports = FindSupports(options, columns);
  const auto floors_m = FindFloors(columns, supports, cameras_in_map);
  GridResult result;
  result.below_lowest_share = ShareBelow(columns, floors_m.front());
  for (std::size_t i = 0; i < floors_m.size(); ++i) {
    const auto ground_m = FindGround(options, columns, supports, floors_m, i);
    FloorGrid floor =
        ClassifyFloor(options, columns, ground_m, floors_m[i], cameras_in_map, num_threads);
    floor.grid = CropToSeen(floor.grid, options.margin_m);
    CountCells(floor);
    const bool is_main = floors_m[i] == 0;
    if (floor.grid.cells.empty() && is_main) {
      throw DataError(
          "nothing is seen between the floor (z = 0) and the robot's height: check that the map "
          "is upright, or raise grid.robot_height_m");
    }
    if (floor.grid.cells.empty()) continue;
    if (is_main) result.main_floor_idx = result.floors.size();
    result.floors.push_back(std::move(floor));
  }
  return result;
}

}  // namespace nightmap
