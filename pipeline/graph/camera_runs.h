// SPDX-License-Identifier: Apache-2.0
// Where the odometry of one camera goes on without a break.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/graph/odometry_chain.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// Consecutive frames of one recording and one camera whose motion was measured.
struct CameraRun {
  int first_frame = 0;
  int camera_idx = 0;
  std::vector<StampedPose> poses;  // graph_from_camera by frame; times ascend

  bool Has(int frame_idx) const {
    return frame_idx >= first_frame && frame_idx < first_frame + static_cast<int>(poses.size());
  }
  // graph_from_camera between frames (rotation by slerp); beyond an end that of the end.
  Rigid3 At(std::int64_t time_ns) const;
};

// Ascending, without the frames of which the camera only guessed. `frames` are those of `chain`.
std::vector<CameraRun> FindCameraRuns(const std::vector<FrameRecord>& frames,
                                      const OdometryChain& chain);

// The run that has both frames; none: null. `runs` ascend.
const CameraRun* RunOf(const std::vector<CameraRun>& runs, int frame_a, int frame_b);

}  // namespace nightmap
