// SPDX-License-Identifier: Apache-2.0
// First poses of a shard's frames by chaining verified pairs.
#pragma once

#include <vector>

#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"

namespace nightmap {

struct ChainedFrame {
  Rigid3 shard_from_camera;
  bool is_posed = false;
  TrackingState state = TrackingState::kTracked;
};

// `frames[i]` is frame `begin_idx + i`. The frame before `first_frame_idx` (the first one when
// there is none) is the origin. Frames before it are posed only when a pair of the own shard
// reaches them.
std::vector<ChainedFrame> ChainPoses(const std::vector<FramePair>& pairs,
                                     int begin_idx,
                                     int first_frame_idx,
                                     int num_frames);

// Pose at a fraction between two poses: linear translation, spherical rotation.
Rigid3 Interpolate(const Rigid3& a, const Rigid3& b, double fraction);

}  // namespace nightmap
