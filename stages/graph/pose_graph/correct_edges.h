// SPDX-License-Identifier: Apache-2.0
// Corrects the edges of a sensor whose mounting pose or clock is wrong.
#pragma once

#include <vector>

#include "stages/graph/pose_graph/pose_graph.h"
#include "stages/graph/pose_graph/sensor_calibration.h"

namespace nightmap {

// Odometry and loops get the corrected mounting, and odometry the clock's offset where the camera
// measured the motion meanwhile: only what WarningsOf warns of. Priors stay. `runs` and `frames`
// are the camera's.
void CorrectEdges(const CalibrationWarnings& options,
                  const std::vector<FrameRecord>& frames,
                  const std::vector<CameraRun>& runs,
                  const SensorCalibration& calibration,
                  SensorGraph* sensor);

}  // namespace nightmap
