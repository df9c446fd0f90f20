// SPDX-License-Identifier: Apache-2.0
// localize/queries.csv: one row a query picture, located or not. Header:
//   query_idx,time_ns,color_path,status,reason,num_matches,num_inliers,reprojection_error_px,
//   tx_m,ty_m,tz_m,qx,qy,qz,qw
// (one line). The pose is map_from_camera, empty on failure; `reason` is empty when located.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

struct QueryResult {
  int query_idx = 0;
  std::int64_t time_ns = 0;
  std::string color_path;
  std::string reason;  // why it could not be located, one word; empty: located
  int num_matches = 0;
  int num_inliers = 0;
  double reprojection_error_px = 0;  // root mean square over the inliers; 0 on failure
  Rigid3 map_from_camera;            // of a located query

  bool IsLocated() const { return reason.empty(); }
};

std::string QueriesToCsv(const std::vector<QueryResult>& queries);
// Throws DataError naming file and line on a wrong header, column count or number, and on a row
// whose status, reason and pose contradict each other.
std::vector<QueryResult> ReadQueries(const std::filesystem::path& path);

// The located queries as a trajectory, in order of time.
std::vector<StampedPose> LocatedPoses(const std::vector<QueryResult>& queries);

}  // namespace nightmap
