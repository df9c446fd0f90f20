// SPDX-License-Identifier: Apache-2.0
// The adjustment rounds after loop closure: first the keyframes, then all described frames. Frames
// that no round adjusts move along with their neighbours.
#pragma once

#include <map>
#include <vector>

#include "stages/pose_graph/global_bundle.h"
#include "stages/pose_graph/odometry_chain.h"

namespace nightmap {

class AdjustmentRounds {
 public:
  // All arguments must outlive this.
  AdjustmentRounds(const PoseGraphOptions& options,
                   const PoseGraphInput& input,
                   const OdometryChain& chain,
                   int num_threads)
      : options_(options), input_(input), chain_(chain), num_threads_(num_threads) {}

  // Adjusts the keyframes and the points of `tracks`, with Huber's loss.
  [[nodiscard]] GlobalBundleSummary AdjustKeyframes(
      std::vector<Track> tracks, std::map<int, Rigid3>* graph_from_keyframe) const;

  // Adjusts the keyframes and all other frames that have descriptors (starting from
  // `graph_from_camera` of all frames), with newly found points, Cauchy's loss and, by option,
  // calibration.
  [[nodiscard]] GlobalBundleSummary AdjustDescribed(std::map<int, Rigid3>* graph_from_keyframe,
                                                    std::vector<Rigid3>* graph_from_camera) const;

  // Poses of all frames. A frame keeps its odometry pose relative to the adjusted frames around it.
  // Between two of them it follows both in proportion, so that the trajectory stays smooth. Before
  // a bridge it follows only the one before it.
  std::vector<Rigid3> CarryFrames(const std::map<int, Rigid3>& adjusted) const;

 private:
  BundleOptions MakeBundleOptions() const;
  PointMotion MotionAt(int frame_idx) const;
  Rigid3 Carried(const std::pair<const int, Rigid3>& adjusted, int frame_idx) const;

  const PoseGraphOptions& options_;
  const PoseGraphInput& input_;
  const OdometryChain& chain_;
  int num_threads_;
};

}  // namespace nightmap
