// SPDX-License-Identifier: Apache-2.0
// Keyframes, and how the frames between move along.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/geometry/rigid2.h"

namespace nightmap {

// Indices of the frames that are `distance_m` or `turn_rad` from the keyframe before; the first and
// the last are keyframes.
std::vector<std::size_t> ChooseKeyframes(const std::vector<Rigid2>& map_from_robot,
                                         double distance_m,
                                         double turn_rad);

// Poses of all frames. A keyframe gets its adjusted pose; a frame between keeps its place as seen
// from the keyframe before and from the one after, weighted by its share of the time between.
std::vector<Rigid2> CarryFrames(const std::vector<Rigid2>& map_from_robot,
                                const std::vector<std::int64_t>& times_ns,
                                const std::vector<std::size_t>& keyframes,
                                const std::vector<Rigid2>& adjusted);

}  // namespace nightmap
