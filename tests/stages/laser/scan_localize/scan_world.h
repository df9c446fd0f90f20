// SPDX-License-Identifier: Apache-2.0
// Shared by tests of scan_localize: a building of boxes, its grid, and queries cast in it.
#pragma once

#include <fmt/format.h>

#include <vector>

#include "pipeline/laser/scan_grid.h"
#include "stages/laser/scan_localize/scan_localize.h"
#include "tests/laser_building.h"

namespace nightmap {

// An L of two rooms with things of different sizes, so that no two places look alike.
inline const Building kRooms = {{{-10, -6}, {10, 6}},
                                {{-1, -6}, {-0.8, 3}},
                                {{-10, 3}, {-5, 6}},
                                {{3, -6}, {5, -4.5}},
                                {{6, 2}, {6.6, 2.6}},
                                {{-7, -3}, {-6, -1.5}}};

// The grid of scans on a lattice of places that are free.
inline OccupancyGrid MapOf(const Building& building, const std::vector<Rigid2>& poses) {
  const Signal scans = ScansAt(building, poses, 0.01);
  std::vector<PlacedScan> placed;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const SignalSample& scan = scans.samples[i];
    placed.push_back(
        {poses[i].ToRigid3(), scan.value[0], scan.value[1], scan.value[2], scan.ranges_m, {}});
  }
  return GridOfScans({}, placed).grid;
}

inline bool IsInside(const Building& building, const Eigen::Vector2d& point, double margin_m) {
  for (const Box2& box : building) {
    const bool is_outer = &box == &building.front();
    const double grow_m = is_outer ? -margin_m : margin_m;
    const bool is_within = (point.array() > box.low.array() - grow_m).all() &&
                           (point.array() < box.high.array() + grow_m).all();
    if (is_within != is_outer) return false;
  }
  return true;
}

inline std::vector<Rigid2> PlacesIn(const Building& building, double step_m) {
  std::vector<Rigid2> poses;
  const Box2& hall = building.front();
  for (double y = hall.low.y() + 0.7; y < hall.high.y(); y += step_m) {
    for (double x = hall.low.x() + 0.7; x < hall.high.x(); x += step_m) {
      if (IsInside(building, {x, y}, 0.4)) poses.push_back({0.3 * x + y, {x, y}});
    }
  }
  return poses;
}

// A scan all around, cast with noise.
inline ScanQuery QueryAt(const Building& building, const Rigid2& pose, std::size_t number) {
  constexpr double kDegree_rad = std::numbers::pi / 180;
  Random random(7, number);
  ScanQuery query{
      fmt::format("scan {}", number), static_cast<std::int64_t>(number) * 1'000'000'000, {}, {}};
  QueryScan scan{{}, -std::numbers::pi, kDegree_rad, 80, {}};
  for (int beam = 0; beam < 360; ++beam) {
    const double heading_rad = pose.heading_rad + scan.first_angle_rad + beam * scan.step_angle_rad;
    const double range_m = RangeToWall_m(building, pose.translation, heading_rad);
    scan.ranges_m.push_back(static_cast<float>(range_m + 0.01 * random.Gaussian()));
  }
  query.scans.push_back(scan);
  return query;
}

// Random poses that are free, and a scan at each.
struct AskedScans {
  std::vector<Rigid2> poses;
  std::vector<ScanQuery> queries;
};
inline AskedScans AskAt(const Building& building, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  AskedScans asked;
  const Box2& hall = building.front();
  while (asked.poses.size() < count) {
    const Rigid2 pose{
        random.Uniform(-std::numbers::pi, std::numbers::pi),
        {random.Uniform(hall.low.x(), hall.high.x()), random.Uniform(hall.low.y(), hall.high.y())}};
    if (!IsInside(building, pose.translation, 0.4)) continue;
    asked.queries.push_back(QueryAt(building, pose, asked.poses.size()));
    asked.poses.push_back(pose);
  }
  return asked;
}

inline double Distance_m(const QueryResult& result, const Rigid2& truth) {
  return (result.map_from_camera.translation.head<2>() - truth.translation).norm();
}
inline double Turn_deg(const QueryResult& result, const Rigid2& truth) {
  const double turn_rad =
      WrapAngle_rad(ToRigid2(result.map_from_camera).heading_rad - truth.heading_rad);
  return std::abs(turn_rad) * 180 / std::numbers::pi;
}

}  // namespace nightmap
