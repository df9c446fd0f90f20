// SPDX-License-Identifier: Apache-2.0
// Fills with the edges of other sensors what the camera lost.
#pragma once

#include <vector>

#include "pipeline/graph/sensor_edges.h"

namespace nightmap {

// Where the camera's odometry only guessed, takes the motion that another sensor measured: the
// bridge becomes a measured edge, frames in between that are nodes get their measured poses, and
// all frames after it move along. The first sensor that crosses a bridge fills it.
FilledBridges FillBridges(const EdgeSigmaFloor& floor,
                          const std::vector<SensorGraph>& sensors,
                          OdometryChain* chain);

}  // namespace nightmap
