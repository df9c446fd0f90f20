// SPDX-License-Identifier: Apache-2.0
// Least squares over a pose graph with loops that may be wrong: graduated non-convexity with a
// truncated least squares loss (Yang, Antonante, Tzoumas, Carlone, RA-L 2020, algorithm 1).
#pragma once

#include <map>
#include <vector>

#include "pipeline/io/odometry_io.h"

namespace nightmap {

struct GraphEdge {
  PoseEdge edge;
  bool is_loop = false;  // may be wrong
  double weight = 1;     // of a loop after optimization, 0 .. 1
  double error = 0;      // Mahalanobis distance after optimization

  bool IsBelieved() const { return !is_loop || weight > 0.5; }
};

// Poses by frame index, world_from_camera; the first is held fixed. `max_loop_error` is the
// Mahalanobis distance beyond which a loop is held to be wrong. Deterministic; one thread. Throws
// DataError when the solver fails.
void OptimizeGraph(double max_loop_error,
                   std::vector<GraphEdge>* edges,
                   std::map<int, Rigid3>* world_from_camera);

}  // namespace nightmap
