// SPDX-License-Identifier: Apache-2.0
// Chains a sensor's short edges until the motion stands out from their noise.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/graph/camera_runs.h"
#include "pipeline/graph/sensor_edges.h"

namespace nightmap {

// A motion that the sensor measured while the camera measured it too.
struct SensorStretch {
  const CameraRun* run = nullptr;
  std::int64_t source_ns = 0;
  std::int64_t target_ns = 0;
  Rigid3 target_from_source;  // of the camera
  Matrix6d covariance;        // of a left perturbation
};

// Stretches of half a metre or 20 degrees, one after the other. A stretch that takes more than 5 s
// is left out: its noise grew while the robot stood. `runs` must outlive the result.
std::vector<SensorStretch> FindSensorStretches(const std::vector<CameraRun>& runs,
                                               const std::vector<PoseEdge>& odometry);

}  // namespace nightmap
