// SPDX-License-Identifier: Apache-2.0
// Finds poses that no camera can have reached.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

struct PoseJumps {
  std::vector<std::int64_t> away_ns;     // times of poses that jumped away, before a jump back
  std::vector<std::int64_t> lasting_ns;  // times of the first pose after a jump that stays
};

// A step between neighbours in time is a jump when it is longer than 0.3 m and faster than 10 m/s:
// faster than a person runs, and farther than tracking trembles. Poses are away when a jump back to
// where the camera was follows within 1 s.
PoseJumps FindPoseJumps(const std::vector<StampedPose>& poses);

}  // namespace nightmap
