// SPDX-License-Identifier: Apache-2.0
// Moves edges of other sensors to the keyframes, and fills with them what the camera lost.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "stages/pose_graph/odometry_chain.h"
#include "stages/pose_graph/sensor_graphs.h"

namespace nightmap {

// Which sensor measured the motion to a keyframe that the camera only guessed; by that keyframe.
using FilledBridges = std::map<int, std::size_t>;

// Where the camera's odometry only guessed, takes the motion that another sensor measured: the
// bridge becomes a measured edge, frames in between that are nodes get their measured poses, and
// all frames after it move along. The first sensor that crosses a bridge fills it.
FilledBridges FillBridges(const PoseGraphOptions& options,
                          const std::vector<SensorGraph>& sensors,
                          OdometryChain* chain);

// The edge between the keyframes nearest to its frames, or from the map to the one of a prior, with
// the options' floor; none: both are one keyframe, or the camera only guessed the motion to them.
std::optional<PoseEdge> AtKeyframes(const PoseGraphOptions& options,
                                    const OdometryChain& chain,
                                    const std::set<int>& keyframes,
                                    const PoseEdge& edge);

// Odometry of all sensors, chained from keyframe to keyframe. Leaves out what fills a bridge.
std::vector<PoseEdge> OdometryOfSensors(const PoseGraphOptions& options,
                                        const OdometryChain& chain,
                                        const std::set<int>& keyframes,
                                        const std::vector<SensorGraph>& sensors,
                                        const FilledBridges& filled);

}  // namespace nightmap
