// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/scan_map.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/input_error.h"
#include "pipeline/plan/distance_transform.h"

namespace nightmap {
namespace {

constexpr double kSearchResolution_m = 0.1;  // cells of the field that the whole map is searched in
constexpr double kSearchSigma_m = 0.1;       // width of the walls in it
constexpr int kNumLevels = 7;                // squares of up to 64 cells
constexpr double kPlaceSigma_m = 0.1;        // a robot stands within three of these of a free cell

Eigen::Vector2d MiddleInMap(const OccupancyGrid& grid) {
  return grid.FromCells(Eigen::Vector2d(grid.width, grid.height) / 2);
}

double HalfExtent(const OccupancyGrid& grid) {
  if (std::ranges::count(grid.cells, kOccupiedCell) == 0) {
    throw InputError(
        {{"grid"}},
        InputError::Remedy::kInText,
        "no cell of the map is occupied, so that no scan can be found in it: check the "
        "job that made it");
  }
  const double half_diagonal_cells = std::hypot(grid.width, grid.height) / 2;
  const bool is_turned = grid.origin_yaw_rad != 0;
  return grid.resolution_m *
         (is_turned ? half_diagonal_cells : std::max(grid.width, grid.height) / 2.0);
}

std::vector<std::int32_t> DistancesOf(const OccupancyGrid& grid, int num_threads) {
  std::vector<std::uint8_t> blocked;
  blocked.reserve(grid.cells.size());
  for (const std::uint8_t cell : grid.cells) blocked.push_back(cell == kOccupiedCell);
  return SquaredDistances(blocked, grid.width, grid.height, false, num_threads);
}

}  // namespace

ScanMap::ScanMap(const ScanMapOptions& options, OccupancyGrid grid, int num_threads)
    : grid_(std::move(grid)),
      field_origin_in_map_(MiddleInMap(grid_)),
      half_extent_m_(HalfExtent(grid_)),
      search_field_(MakeField(kOccupiedCell, kSearchResolution_m, kSearchSigma_m)),
      place_field_(MakeField(kFreeCell, kSearchResolution_m, kPlaceSigma_m)),
      fine_field_(MakeField(kOccupiedCell, grid_.resolution_m, options.sigma_m)),
      search_pyramid_(search_field_, kNumLevels),
      places_(place_field_, kNumLevels),
      squared_distances_(DistancesOf(grid_, num_threads)) {}

LikelihoodField ScanMap::MakeField(CellValue value, double resolution_m, double sigma_m) const {
  std::vector<Eigen::Vector2d> points_in_field;
  for (int y = 0; y < grid_.height; ++y) {
    for (int x = 0; x < grid_.width; ++x) {
      if (grid_.At({x, y}) == value) points_in_field.push_back(ToField(grid_.CenterInMap({x, y})));
    }
  }
  LikelihoodField field(
      {.resolution_m = resolution_m, .half_extent_m = half_extent_m_ + 1, .sigma_m = sigma_m});
  field.Add(points_in_field);
  return field;
}

double ScanMap::WallDistance_m(const Eigen::Vector2i& cell) const {
  return grid_.resolution_m *
         std::sqrt(static_cast<double>(squared_distances_[grid_.Index(cell.x(), cell.y())]));
}

}  // namespace nightmap
