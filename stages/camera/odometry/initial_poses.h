// SPDX-License-Identifier: Apache-2.0
// Initial poses of a shard's frames by chaining verified pairs.
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

// `frames[i]` is frame `begin_idx + i`. The origin is the frame before `first_frame_idx`, or the
// first frame when there is none. Frames before the origin are posed only when a pair of the own
// shard reaches them.
std::vector<ChainedFrame> ChainPoses(const std::vector<FramePair>& pairs,
                                     int begin_idx,
                                     int first_frame_idx,
                                     int num_frames);

// Pose at a fraction between two poses: linear translation, spherical rotation.
Rigid3 Interpolate(const Rigid3& a, const Rigid3& b, double fraction);

}  // namespace nightmap
