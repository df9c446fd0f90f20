// SPDX-License-Identifier: Apache-2.0
// Runs the plan stage in its tests.
#pragma once

#include <string>
#include <vector>

#include "stages/plan/plan/plan.h"
#include "tests/test_data.h"

namespace nightmap {

inline PlanResult Plan(const PlanOptions& options, const PlanInputs& inputs, int num_threads = 1) {
  return RunPlan(options, inputs, NoProgress(), num_threads);
}

inline PlanOptions Between(const std::string& start,
                           const std::string& goal,
                           double robot_radius_m,
                           double snap_radius_m = 1) {
  PlanOptions options;
  options.start = start;
  options.goal = goal;
  options.footprint.robot_radius_m = robot_radius_m;
  options.snap_radius_m = snap_radius_m;
  return options;
}

// A point as an end.
inline std::string TextOf(const Eigen::Vector2d& point_in_map) {
  return fmt::format("{},{}", point_in_map.x(), point_in_map.y());
}

// Planning ends with an error whose message contains each of the parts.
template <typename ErrorType = DataError>
void ExpectError(const PlanOptions& options,
                 const PlanInputs& inputs,
                 const std::vector<std::string>& parts) {
  SCOPED_TRACE(options.start + " to " + options.goal);
  for (const std::string& part : parts) {
    NIGHTMAP_EXPECT_ERROR(ErrorType, Plan(options, inputs), part);
  }
}

// A picture or a scan.
inline QueryResult Located(const std::string& name, double x, double y) {
  QueryResult query;
  query.verdict = QueryVerdict::kLocated;
  query.color_path = name;
  query.map_from_camera.translation = {x, y, 1.2};
  return query;
}

inline QueryResult Lost(const std::string& name, const std::string& reason) {
  QueryResult query;
  query.verdict = QueryVerdict::kNotInMap;
  query.color_path = name;
  query.reason = reason;
  return query;
}

}  // namespace nightmap
