// SPDX-License-Identifier: Apache-2.0
// Least squares over a pose graph in which loops may be wrong: graduated non-convexity with a
// truncated least squares loss (Yang, Antonante, Tzoumas, Carlone, RA-L 2020, algorithm 1).
#pragma once

#include <map>
#include <vector>

#include "pipeline/io/odometry_io.h"
#include "stages/graph/pose_graph/graph_solver.h"

namespace nightmap {

struct GraphEdge {
  PoseEdge edge;
  bool is_loop = false;       // may be wrong
  double weight = 1;          // weight of a loop after optimization, 0 .. 1
  double error = 0;           // Mahalanobis distance after optimization
  bool is_of_sensor = false;  // odometry or prior of a sensor other than the camera

  bool IsBelieved() const { return !is_loop || weight > 0.5; }
};

struct GraduationSummary {
  int num_rounds = 0;  // in which loops gained or lost weight
  GraphSummary last;   // of the least squares over the accepted edges
};

// Mahalanobis distance between the measured and the actual b_from_a.
double ErrorOf(const PoseEdge& edge, const Rigid3& world_from_a, const Rigid3& world_from_b);

// Poses by frame index, world_from_camera; the first is held fixed. A loop begins with the weight
// that its error at these poses gives it. Beyond the Mahalanobis distance
// `max_loop_error` a loop counts as wrong. Deterministic; one thread. Throws DataError when the
// solver fails.
[[nodiscard]] GraduationSummary OptimizeGraph(double max_loop_error,
                                              std::vector<GraphEdge>* edges,
                                              std::map<int, Rigid3>* world_from_camera);

}  // namespace nightmap
