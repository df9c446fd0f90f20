// SPDX-License-Identifier: Apache-2.0
// A floor's grid, prepared for looking up scans in it.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/laser/field_pyramid.h"

namespace nightmap {

struct ScanMapOptions {
  OPTION(double, sigma_m, 0.05, {0.01, 1}, "width of the walls for the final pose");
  REGISTER_OPTIONS();
};

// Fields have a frame of their own: that of the map, moved to the middle of the grid.
class ScanMap {
 public:
  // Throws InputError of the port `grid` when no cell is occupied.
  ScanMap(const ScanMapOptions& options, OccupancyGrid grid, int num_threads);
  ScanMap(const ScanMap&) = delete;
  ScanMap& operator=(const ScanMap&) = delete;

  const OccupancyGrid& Grid() const { return grid_; }
  // A square about the middle of the grid holds all of its walls.
  double HalfExtent_m() const { return half_extent_m_; }
  Eigen::Vector2d ToField(const Eigen::Vector2d& point_in_map) const {
    return point_in_map - field_origin_in_map_;
  }
  Rigid2 ToMap(const Rigid2& field_from_robot) const {
    return {field_from_robot.heading_rad, field_from_robot.translation + field_origin_in_map_};
  }
  Rigid2 FieldFrom(const Rigid2& map_from_robot) const {
    return {map_from_robot.heading_rad, ToField(map_from_robot.translation)};
  }
  // Coarse and wide, to search in; where a robot can be, at the same cells; with the cells of the
  // grid, to refine in.
  const FieldPyramid& SearchPyramid() const { return search_pyramid_; }
  const FieldPyramid& Places() const { return places_; }
  const LikelihoodField& FineField() const { return fine_field_; }
  // From the centre of a cell to that of the nearest occupied one.
  double WallDistance_m(const Eigen::Vector2i& cell) const;

 private:
  LikelihoodField MakeField(CellValue value, double resolution_m, double sigma_m) const;

  OccupancyGrid grid_;
  Eigen::Vector2d field_origin_in_map_;
  double half_extent_m_;
  LikelihoodField search_field_, place_field_, fine_field_;
  FieldPyramid search_pyramid_, places_;
  std::vector<std::int32_t> squared_distances_;
};

}  // namespace nightmap
