// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

void PoseGraphOptions::Register(OptionList& list) {
  list.Add("edge_sigma_floor_m",
           &edge_sigma_floor.m,
           Range(1e-5, 1),
           "added in quadrature to every edge's translation");
  list.Add("edge_sigma_floor_rad",
           &edge_sigma_floor.rad,
           Range(1e-5, 1),
           "added in quadrature to every edge's rotation");
  list.Add("max_drift",
           &max_drift,
           Range(0.5, 1e9),
           "Mahalanobis distance from the odometry beyond which a loop is rejected");
  list.Add("max_loop_error",
           &max_loop_error,
           Range(0.5, 1000),
           "Mahalanobis distance in the graph beyond which a loop is rejected");
}

}  // namespace nightmap
