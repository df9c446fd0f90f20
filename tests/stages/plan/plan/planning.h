// SPDX-License-Identifier: Apache-2.0
// Runs the plan stage in its tests.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "pipeline/base/error.h"
#include "stages/plan/plan/plan.h"

namespace nightmap {

inline PlanResult Plan(const PlanOptions& options, const PlanInputs& inputs, int num_threads = 1) {
  Progress progress("plan", false);
  return RunPlan(options, inputs, progress, num_threads);
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

// The message of the error that planning ends with.
template <typename ErrorType = DataError>
std::string ErrorOf(const PlanOptions& options, const PlanInputs& inputs) {
  try {
    Plan(options, inputs);
  } catch (const ErrorType& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

}  // namespace nightmap
