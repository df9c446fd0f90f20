// SPDX-License-Identifier: Apache-2.0
#include "stages/grid/grid.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/base/error.h"
#include "stages/grid/columns.h"

namespace nightmap {
namespace {

CellValue Seen(const GridOptions& options, double resolution_m, const Column& column) {
  const double unseen_m = resolution_m * column.NumUnseen();
  const bool is_seen = column.floor || column.num_free > 0;
  return is_seen && unseen_m <= options.max_unseen_m + 1e-9 ? kFreeCell : kUnknownCell;
}

CellValue Classify(const GridOptions& options, double resolution_m, const Column& column) {
  const bool occupied = column.num_occupied >= options.min_occupied_voxels;
  return occupied ? kOccupiedCell : Seen(options, resolution_m, column);
}

int CountOccupiedNeighbors(const OccupancyGrid& grid, int x, int y) {
  int count = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const Eigen::Vector2i cell(x + dx, y + dy);
      if (dx == 0 && dy == 0) continue;
      count += grid.Contains(cell) && grid.At(cell) == kOccupiedCell ? 1 : 0;
    }
  }
  return count;
}

// A lone cell is a speck only when its column is low too: a thin pole stays an obstacle.
std::size_t RemoveSpecks(const GridOptions& options, const Columns& columns, OccupancyGrid& grid) {
  std::vector<std::size_t> specks;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::size_t i = grid.Index(x, y);
      if (grid.cells[i] == kOccupiedCell &&
          columns.columns[i].num_occupied <= options.speck_max_voxels &&
          CountOccupiedNeighbors(grid, x, y) < options.speck_min_neighbors) {
        specks.push_back(i);
      }
    }
  }
  for (const std::size_t i : specks)
    grid.cells[i] = Seen(options, grid.resolution_m, columns.columns[i]);
  return specks.size();
}

OccupancyGrid MakeGrid(const GridOptions& options, const Columns& columns, double resolution_m) {
  OccupancyGrid grid;
  grid.width = columns.area.width;
  grid.height = columns.area.height;
  grid.resolution_m = resolution_m;
  grid.origin_in_map = Eigen::Vector2d(columns.area.min_x, columns.area.min_y) * resolution_m;
  grid.cells.reserve(columns.columns.size());
  for (const Column& column : columns.columns) {
    grid.cells.push_back(Classify(options, resolution_m, column));
  }
  return grid;
}

// To a nanometre: multiples of the resolution print short in the YAML.
Eigen::Vector2d Rounded(const Eigen::Vector2d& point_m) {
  return (point_m * 1e9).array().round() / 1e9;
}

// The part of the grid with known cells and an unknown border around it.
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
  if (high.x() < 0) throw DataError("the grid has no free and no occupied cell: widen the band");
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

}  // namespace

void GridOptions::Register(OptionList& list) {
  list.Add("obstacle_min_height_m",
           &obstacle_min_height_m,
           Range(0.0, 2.0),
           "voxels whose centre is lower are floor, never an obstacle");
  list.Add("obstacle_max_height_m",
           &obstacle_max_height_m,
           Range(0.05, 10.0),
           "voxels whose centre is higher are above the robot");
  list.Add("min_occupied_voxels",
           &min_occupied_voxels,
           Range(1, 100),
           "occupied voxels in the band that make a cell occupied");
  list.Add("max_unseen_m",
           &max_unseen_m,
           Range(0, 10),
           "unseen height between free voxels above which a cell is unknown, not free");
  list.Add("speck_min_neighbors",
           &speck_min_neighbors,
           Range(0, 8),
           "a cell with fewer occupied neighbours (of 8) is a speck and is removed; 0: keep all");
  list.Add("speck_max_voxels",
           &speck_max_voxels,
           Range(0, 100),
           "a column with more occupied voxels is never a speck");
  list.Add("margin_m", &margin_m, Range(0.0, 10.0), "unknown border kept around the seen area");
}

GridResult RunGrid(const GridOptions& options, const OccupancyTree& tree, Progress& progress) {
  const Band band =
      MakeBand(options.obstacle_min_height_m, options.obstacle_max_height_m, tree.resolution_m);
  const Columns columns = CollectColumns(tree, band, progress);
  GridResult result;
  result.grid = MakeGrid(options, columns, tree.resolution_m);
  result.num_removed_specks = RemoveSpecks(options, columns, result.grid);
  for (const Column& column : columns.columns) result.num_floor_cells += column.floor ? 1 : 0;
  result.grid = CropToSeen(result.grid, options.margin_m);
  const auto count = [&](CellValue value) {
    return static_cast<std::size_t>(
        std::count(result.grid.cells.begin(), result.grid.cells.end(), value));
  };
  result.num_free_cells = count(kFreeCell);
  result.num_occupied_cells = count(kOccupiedCell);
  result.num_unknown_cells = count(kUnknownCell);
  return result;
}

}  // namespace nightmap
