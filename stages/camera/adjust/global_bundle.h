// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment after loop closure, of all keyframes or of all described frames.
#pragma once

#include <map>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"
#include "stages/camera/adjust/adjust.h"
#include "stages/camera/adjust/track_list.h"

namespace nightmap {

struct GlobalBundleSummary {
  double rms_px = 0;
  int num_observations = 0;
  std::vector<CameraCalibration> calibrations;  // by camera
  std::vector<BundleSummary> adjustments;       // in order
  DepthOffsets depth_offsets;                   // estimated when calibrating
};

// Keeps the longest tracks of each frame and adjusts the frames' poses and the points. The first
// frame is held fixed as the graph's gauge. `motions` are those of these frames, for the rolling
// shutter; if empty, all frames stand still. Lets go of the features in
// memory once their observations are known. Throws DataError when an adjustment fails.
[[nodiscard]] GlobalBundleSummary AdjustFrames(const AdjustInput& input,
                                               const BundleOptions& bundle_options,
                                               TrackList tracks,
                                               const std::map<int, PointMotion>& motions,
                                               std::map<int, Rigid3>* graph_from_frame);

}  // namespace nightmap
