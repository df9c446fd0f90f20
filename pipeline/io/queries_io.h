// SPDX-License-Identifier: Apache-2.0
// localize/queries.csv: one row per query picture, located or not. Header (one line):
//   query_idx,time_ns,color_path,status,reason,num_matches,num_inliers,num_rival_inliers,confidence,
//   reprojection_error_px,position_sigma_m,rotation_sigma_deg,tx_m,ty_m,tz_m,qx,qy,qz,qw
// `status` is the verdict. The pose is map_from_camera; for an ambiguous picture it is that of the
// best supported place. `reason` is empty when located.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

enum class QueryVerdict {
  kLocated,
  kAmbiguous,   // two places explain the picture about as well
  kNotInMap,    // no place explains it
  kNoFeatures,  // the picture shows nothing recognizable
  kUnreadable,
};

// located, ambiguous, not_in_map, no_features, unreadable.
std::string_view QueryVerdictText(QueryVerdict verdict);

struct QueryResult {
  int query_idx = 0;
  std::int64_t time_ns = 0;
  std::string color_path;
  QueryVerdict verdict = QueryVerdict::kNotInMap;
  std::string reason;  // why it was not located, one word
  int num_matches = 0;
  int num_inliers = 0;
  int num_rival_inliers = 0;  // inliers of the pose in the second best place
  // 0 to 1: lead over its rival in the features' votes, at most 1 - chance and 1 - doubt in it.
  double confidence = 0;
  double reprojection_error_px = 0;  // root mean square over the inliers
  double position_sigma_m = 0;       // standard deviation over all axes, the map's own included
  double rotation_sigma_deg = 0;
  Rigid3 map_from_camera;

  bool IsLocated() const { return verdict == QueryVerdict::kLocated; }
  bool HasPose() const { return IsLocated() || verdict == QueryVerdict::kAmbiguous; }
};

std::string QueriesToCsv(const std::vector<QueryResult>& queries);
// Throws DataError naming file and line on a wrong header, column count or number, and on a row
// whose status, reason and pose contradict each other.
std::vector<QueryResult> ReadQueries(const std::filesystem::path& path);

// The located queries as a trajectory, in order of time.
std::vector<StampedPose> LocatedPoses(const std::vector<QueryResult>& queries);

}  // namespace nightmap
