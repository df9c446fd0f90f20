// SPDX-License-Identifier: Apache-2.0
// How far and where the wheels went, from samples of their odometry.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/recording/signals_io.h"

namespace nightmap {

// The wheels' way from one moment to a later one.
struct WheelMotion {
  Rigid3 start_from_end;  // in the plane
  double distance_m = 0;  // along the way
  double turn_rad = 0;    // of all turns, left or right
};

// Whether a robot can drive from one sample of its odometry to the next one. A driver that starts
// again, or a counter that was set back, jumps farther, or to the origin.
bool IsPossibleStep(const SignalSample& before, const SignalSample& after);

// `samples` hold x, y (m), heading (rad). Between two of them the wheels drive an arc at constant
// speed. None when not all of the way was sampled: before the first sample, after the last, with a
// longer gap between two, or with a step that no robot makes. Pure.
std::optional<WheelMotion> MotionBetween(const std::vector<SignalSample>& samples,
                                         double max_gap_s,
                                         std::int64_t start_ns,
                                         std::int64_t end_ns);

}  // namespace nightmap
