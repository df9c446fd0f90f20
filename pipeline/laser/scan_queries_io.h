// SPDX-License-Identifier: Apache-2.0
// queries/queries.h5 of a laser site: what a robot scanned at the places that it asks for.
//
// HDF5, for Q queries with S scans in total, query after query:
//   name_offset, name    int64[Q + 1], uint8      UTF-8 names, one after the other
//   time_ns              int64[Q]                 increases
//   scan_offset          int64[Q + 1]             where each query's scans start
//   query_from_laser     double[S x 3]            heading (rad), x, y (m)
//   beams                double[S x 3]            first angle and step (rad), range limit (m)
//   range_offset         int64[S + 1]             where each scan's ranges start
//   range_m              float[R]
//   rough_position       double[Q x 3]            x, y in the map and radius (m); radius 0: none
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid2.h"

namespace nightmap {

// Beam i points at first_angle_rad + i * step_angle_rad, counter-clockwise from the laser's x.
struct QueryScan {
  Rigid2 query_from_laser;
  double first_angle_rad = 0;
  double step_angle_rad = 0;
  double limit_m = 0;           // the scanner reports this or more where it hit nothing
  std::vector<float> ranges_m;  // zero, NaN and infinity hit nothing either

  // The range is positive, finite and below the limit.
  bool IsHit(std::size_t beam) const { return ranges_m[beam] > 0 && ranges_m[beam] < limit_m; }
  double Angle_rad(std::size_t beam) const {
    return first_angle_rad + static_cast<double>(beam) * step_angle_rad;
  }
};

struct RoughPosition {
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  double radius_m = 0;  // the robot is within
};

// The query's frame is that of the robot at time_ns: x ahead, z up.
struct ScanQuery {
  std::string name;  // not empty, on one line
  std::int64_t time_ns = 0;
  std::vector<QueryScan> scans;  // one, or those of a robot that turned on the spot
  std::optional<RoughPosition> rough_position;
};

// Points hit by scans up to max_range_m from their laser, in the query's frame, scan after scan.
std::vector<Eigen::Vector2d> PointsInQuery(const ScanQuery& query, double max_range_m);

// Equal queries give equal bytes. Ranges that are NaN or infinite are written as 0. Throws
// DataError.
void WriteScanQueries(const std::filesystem::path& path, const std::vector<ScanQuery>& queries);

// Throws DataError naming file and field on sizes that do not add up, NaN, an empty name or one of
// several lines, times that do not increase, a negative radius, an angle step of 0, a scan more
// than 1 km from its query, or a rough position or radius beyond 1000 km.
std::vector<ScanQuery> ReadScanQueries(const std::filesystem::path& path);

}  // namespace nightmap
