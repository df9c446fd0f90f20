// SPDX-License-Identifier: Apache-2.0
// Poses of all frames from those of some, and their text.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "pipeline/graph/odometry_chain.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// Poses of all frames, from graph_from_camera of some, which include frame 0. A frame keeps its
// odometry pose relative to these frames around it. Between two of them it follows both in
// proportion, so that the trajectory stays smooth. Before a bridge it follows only the one before
// it.
std::vector<Rigid3> CarryFrames(const OdometryChain& chain, const std::map<int, Rigid3>& poses);

// TUM text of all frames; `graph_from_camera` by frame.
std::string TrajectoryText(const std::vector<FrameRecord>& frames,
                           const std::vector<Rigid3>& graph_from_camera);

// TUM text of the keyframes only.
std::string KeyframesText(const std::vector<FrameRecord>& frames,
                          const std::vector<Rigid3>& graph_from_camera,
                          const std::set<int>& keyframes);

}  // namespace nightmap
