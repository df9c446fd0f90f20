// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/search_box.h"

namespace nightmap {

SearchBox BoxOf(const ScanMap& map, const ScanQuery& query) {
  if (query.rough_position) {
    const Eigen::Vector2d radius = Eigen::Vector2d::Constant(query.rough_position->radius_m);
    const Eigen::Vector2d& middle = query.rough_position->point_in_map;
    return {middle - radius, middle + radius};
  }
  const OccupancyGrid& grid = map.Grid();
  SearchBox box{grid.origin_in_map, grid.origin_in_map};
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(grid.width, 0),
                                        Eigen::Vector2d(0, grid.height),
                                        Eigen::Vector2d(grid.width, grid.height)}) {
    box.low = box.low.cwiseMin(grid.FromCells(corner));
    box.high = box.high.cwiseMax(grid.FromCells(corner));
  }
  return box;
}

bool CanBeAt(const ScanMap& map, const ScanQuery& query, const Eigen::Vector2d& point_in_map) {
  const auto& rough = query.rough_position;
  if (rough && (point_in_map - rough->point_in_map).norm() > rough->radius_m) return false;
  const LikelihoodField& places = map.Places().Field();
  const Eigen::Vector2d cell = places.ToCells(map.ToField(point_in_map)).array().round();
  return places.At(static_cast<int>(cell.x()), static_cast<int>(cell.y())) > 0;
}

}  // namespace nightmap
