// SPDX-License-Identifier: Apache-2.0
// The adjustment rounds after loop closure: first the keyframes, then all described frames. Frames
// that no round adjusts move along with their neighbours.
#pragma once

#include <map>
#include <vector>

#include "stages/camera/adjust/global_bundle.h"

namespace nightmap {

class AdjustmentRounds {
 public:
  // `options` and `input` must outlive this.
  AdjustmentRounds(const AdjustOptions& options, const AdjustInput& input, int num_threads)
      : options_(options), input_(input), num_threads_(num_threads) {}

  // Adjusts the keyframes and the points of `tracks`, with Huber's loss.
  [[nodiscard]] GlobalBundleSummary AdjustKeyframes(
      TrackList tracks, std::map<int, Rigid3>* graph_from_keyframe) const;

  // Adjusts the keyframes and all other frames that have descriptors (starting from
  // `graph_from_camera` of all frames), with newly found points, Cauchy's loss and, by option,
  // calibration.
  [[nodiscard]] GlobalBundleSummary AdjustDescribed(std::map<int, Rigid3>* graph_from_keyframe,
                                                    std::vector<Rigid3>* graph_from_camera) const;

 private:
  BundleOptions MakeBundleOptions() const;
  PointMotion MotionAt(int frame_idx) const;

  const AdjustOptions& options_;
  const AdjustInput& input_;
  int num_threads_;
};

}  // namespace nightmap
