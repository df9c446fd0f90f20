// SPDX-License-Identifier: Apache-2.0
// Follows corners from one picture to the next by optical flow (pyramidal Lucas-Kanade: Bouguet,
// Pyramidal implementation of the Lucas Kanade feature tracker, 2000), and puts each back onto its
// corner, so that tracks do not drift.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/camera/follow_corners.h"

namespace nightmap {

struct FlowOptions {
  OPTION(int, border_px, 10, {0, 100}, "a track ends as near to the picture's border");
  REGISTER_OPTIONS();
};

// A picture ready for flow: its pyramid and gradients, at a mean and contrast that are the same for
// all pictures, so that a change of light between two pictures does not look like motion.
FlowPyramid PrepareForFlow(const GrayImage& gray);

// Why a track ended.
enum class TrackEnd {
  kBorder,      // the corner left the picture, or what the lens has a ray for
  kLost,        // no flow found
  kBackward,    // the flow back leads elsewhere
  kOffCorner,   // where the flow leads is no corner
  kMerged,      // an older track came too near
  kNewPicture,  // unreadable picture, or the first of another camera or sequence
};
constexpr int kNumTrackEnds = 6;

struct FollowedCorner {
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  std::optional<TrackEnd> end;  // nothing: found
};

// Looks for the corners at `pixels` of `from` in `to`, each first where it lay plus its predicted
// step. One entry per corner. Deterministic.
std::vector<FollowedCorner> FollowCorners(const FlowPyramid& from,
                                          const FlowPyramid& to,
                                          const std::vector<Eigen::Vector2f>& pixels,
                                          const std::vector<Eigen::Vector2f>& steps_px,
                                          const FlowOptions& options);

}  // namespace nightmap
