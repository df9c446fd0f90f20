// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/object_views.h"

#include <algorithm>
#include <cmath>

#include "pipeline/plan/cell_walk.h"

namespace nightmap {
namespace {

// Walls of the map are a cell thick, and a beam that meets one at a flat angle ends early or late.
constexpr double kSameWall_m = 0.15;

// The beam that points at a bearing in the frame of the laser; -1: none.
int BeamAt(const QueryScan& scan, double bearing_rad) {
  const double middle_rad =
      scan.Angle_rad(0) + 0.5 * scan.step_angle_rad * static_cast<double>(scan.ranges_m.size() - 1);
  const double from_first_rad =
      middle_rad + WrapAngle_rad(bearing_rad - middle_rad) - scan.first_angle_rad;
  const double beam = std::round(from_first_rad / scan.step_angle_rad);
  const bool is_seen = beam >= 0 && beam < static_cast<double>(scan.ranges_m.size());
  return is_seen ? static_cast<int>(beam) : -1;
}

// Beams around one, so that none that passes close by a corner refuses it.
constexpr int kNumAround = 3;
struct Hits {
  int num_on_it = 0;
  int num_beyond = 0;

  bool Confirm() const { return num_on_it > 0; }
  bool Contradict() const { return num_on_it == 0 && num_beyond == kNumAround; }
};
Hits HitsAround(const QueryScan& scan, int beam, double distance_m) {
  Hits hits;
  if (beam < 0) return hits;
  const int end = static_cast<int>(scan.ranges_m.size());
  for (int i = std::max(0, beam - 1); i < std::min(end, beam + 2); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (!scan.IsHit(at)) continue;
    const double beyond_m = scan.ranges_m[at] - distance_m;
    hits.num_on_it += std::abs(beyond_m) <= kSameWall_m;
    hits.num_beyond += beyond_m > kSameWall_m;
  }
  return hits;
}

// Whether another wall of the map stands before one.
bool IsBehindWall(const OccupancyGrid& grid,
                  const Eigen::Vector2d& laser_in_map,
                  const Eigen::Vector2d& wall_in_map) {
  bool is_behind = false;
  WalkCells(grid.ToCells(laser_in_map), grid.ToCells(wall_in_map), [&](const auto& cell) {
    if (is_behind || !grid.Contains(cell) || grid.At(cell) != kOccupiedCell) return;
    is_behind = (grid.CenterInMap(cell) - wall_in_map).norm() > kSameWall_m;
  });
  return is_behind;
}

// The beam of a scan that points at a wall within its range; -1: none.
int BeamTo(const QueryScan& scan, const Eigen::Vector2d& wall_in_laser, double max_range_m) {
  const double distance_m = wall_in_laser.norm();
  if (scan.ranges_m.empty() || distance_m > max_range_m || distance_m < kSameWall_m) return -1;
  return BeamAt(scan, std::atan2(wall_in_laser.y(), wall_in_laser.x()));
}

Hits HitsTowards(const QueryScan& scan, const Eigen::Vector2d& wall_in_laser, double max_range_m) {
  return HitsAround(scan, BeamTo(scan, wall_in_laser, max_range_m), wall_in_laser.norm());
}

}  // namespace

std::vector<Eigen::Vector2d> WallsOfObjects(const OccupancyGrid& grid,
                                            const std::vector<MapObject>& objects) {
  std::vector<Eigen::Vector2d> walls;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (grid.At({x, y}) != kOccupiedCell) continue;
      const Eigen::Vector2d center = grid.CenterInMap({x, y});
      const auto holds = [&](const MapObject& object) { return Contains(object, center); };
      if (std::ranges::any_of(objects, holds)) walls.push_back(center);
    }
  }
  return walls;
}

ObjectView ViewObjects(const std::vector<Eigen::Vector2d>& walls_in_map,
                       const ScanQuery& query,
                       const Rigid2& map_from_query,
                       double max_range_m) {
  ObjectView view;
  for (const QueryScan& scan : query.scans) {
    const Rigid2 laser_from_map = (map_from_query * scan.query_from_laser).Inverse();
    for (const Eigen::Vector2d& wall_in_map : walls_in_map) {
      const Hits hits = HitsTowards(scan, laser_from_map * wall_in_map, max_range_m);
      view.num_confirmed += hits.Confirm();
      view.num_contradicted += hits.Contradict();
    }
  }
  return view;
}

ObjectView ViewInSight(const OccupancyGrid& grid,
                       const std::vector<Eigen::Vector2d>& walls_in_map,
                       const ScanQuery& query,
                       const Rigid2& map_from_query,
                       double max_range_m) {
  ObjectView view;
  for (const Eigen::Vector2d& wall : walls_in_map) {
    bool is_confirmed = false, is_contradicted = false;
    for (const QueryScan& scan : query.scans) {
      const Rigid2 map_from_laser = map_from_query * scan.query_from_laser;
      const Hits hits = HitsTowards(scan, map_from_laser.Inverse() * wall, max_range_m);
      if (!hits.Confirm() && !hits.Contradict()) continue;
      if (IsBehindWall(grid, map_from_laser.translation, wall)) continue;
      (hits.Confirm() ? is_confirmed : is_contradicted) = true;
    }
    view.num_confirmed += is_confirmed;
    view.num_contradicted += is_contradicted && !is_confirmed;
  }
  return view;
}

}  // namespace nightmap
