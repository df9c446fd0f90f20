// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/pose_graph.h"

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
  list.Add("sensor_min_error_m",
           &calibration_warnings.min_error_m,
           Range(0, 100),
           "a sensor's mounting pose that is farther off is warned of");
  list.Add("sensor_min_error_rad",
           &calibration_warnings.min_error_rad,
           Range(0, 4),
           "likewise, turned by more");
  list.Add("sensor_min_error_s",
           &calibration_warnings.min_error_s,
           Range(0, 100),
           "a sensor's clock that is farther off is warned of");
  list.Add("calibrate_sensors",
           &calibrate_sensors,
           "correct the edges of a sensor by what is warned of");
  list.Add("min_connected_ratio",
           &min_connected_ratio,
           Range(0, 1),
           "fails when measured motion connects a smaller share of the frames; of sites with many "
           "recordings that never meet, lower it");
}

}  // namespace nightmap
