// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment of all keyframes after loop closure.
#pragma once

#include <map>
#include <vector>

#include "stages/pose_graph/merged_tracks.h"
#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

struct GlobalBundleSummary {
  double rms_px = 0;
  int num_observations = 0;
  std::vector<double> depth_scales;  // of each camera: true depth over measured, see BundleProblem
};

// Keeps the longest tracks of each keyframe, and adjusts keyframes and points. The first keyframe
// is held fixed: it is the graph's gauge.
GlobalBundleSummary AdjustKeyframes(const PoseGraphOptions& options,
                                    const PoseGraphInput& input,
                                    std::vector<Track> tracks,
                                    std::map<int, Rigid3>* graph_from_keyframe);

}  // namespace nightmap
