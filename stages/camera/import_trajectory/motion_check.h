// SPDX-License-Identifier: Apache-2.0
// Compares a given trajectory with the camera motion that features with depth show: two frames seen
// shortly after one another measure their relative pose to a few millimetres and milliradians,
// whatever the trajectory drifts by in the long run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/camera/verify_pairs.h"

namespace nightmap {

// The motion between two frames by their features alone.
struct MeasuredMotion {
  std::int64_t time_a_ns = 0;
  std::int64_t time_b_ns = 0;
  Rigid3 b_from_a;
};

// Measures pairs of neighbouring described frames that the trajectory has poses of: at most 300,
// spread evenly over the recording. Deterministic at any number of threads.
std::vector<MeasuredMotion> MeasureMotions(const FramesWithFeatures& input,
                                           const std::vector<StampedPose>& given,
                                           int num_threads,
                                           Progress& progress);

struct MotionVerdict {
  int num_motions = 0;        // compared: those that moved or turned enough to tell
  int num_agreeing = 0;       // the given lengths divided by `scale` first
  double scale = 1;           // median of given to measured lengths
  std::string contradiction;  // what is wrong and the remedy; empty if the trajectory can be right
  std::string doubt;          // likewise, of a trajectory that can still be used
};

// Fewer than kMinMotions motions tell nothing, and give neither contradiction nor doubt. A
// trajectory contradicts the recording when lengths are off by more than a factor of two or most
// motions disagree by more than 30 %. Names the remedy that makes most of them agree: quaternions
// in another order, inverse poses, axes of a robot, shifted times.
inline constexpr int kMinMotions = 15;
MotionVerdict CompareMotions(const std::vector<StampedPose>& given,
                             const std::vector<MeasuredMotion>& measured);

}  // namespace nightmap
