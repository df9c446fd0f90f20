// SPDX-License-Identifier: Apache-2.0
// Says how far the features of a labelled frame can be followed by optical flow, as the stage
// features will do it: beyond that a frame must be described, and for this be labelled.
#pragma once

#include <vector>

#include "pipeline/features/track_features.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// Follows FAST corners, which are found faster than the features of the map and are lost about
// where these are. Deterministic; one thread.
class FlowFollower {
 public:
  explicit FlowFollower(const std::vector<RgbdCamera>& cameras);

  // Goes on from a labelled frame, whose mask holds what moves.
  void Start(const FrameRecord& frame, const ColorImage& color, const GrayImage& moving);
  // Whether enough is found again in the next frame, which need not be labelled then. False before
  // Start and for a frame of another camera.
  bool Follows(const FrameRecord& frame, const ColorImage& color);

 private:
  const std::vector<RgbdCamera>& cameras_;
  FeatureTracker tracker_;
  int camera_idx_ = -1;  // of the labelled frame
};

}  // namespace nightmap
