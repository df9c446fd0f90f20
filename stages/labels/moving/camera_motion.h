// SPDX-License-Identifier: Apache-2.0
// The camera's motion between two frames near in time, whatever else moves.
#pragma once

#include <cstdint>
#include <optional>

#include "stages/labels/moving/small_frame.h"

namespace nightmap {

struct CameraMotionOptions {
  int cell_px = 10;               // of the reduced gray picture; one corner is followed per cell
  int window_px = 15;             // of the optical flow
  double max_error_px = 1.5;      // of the reduced gray picture
  double max_depth_error = 0.05;  // relative
  int min_inliers = 12;
  double min_share = 0.5;  // of the surface, that must agree with a motion
};

// Follows the strongest corner of each cell of the picture from a to b by optical flow (pyramidal
// Lucas-Kanade: Bouguet, 2000), back again to check it, and takes the rigid motion (b from a) that
// the largest surface agrees with. Things that may move by their labels count little. Returns
// nothing when no motion has min_inliers and min_share of the surface. Deterministic in the seed.
std::optional<Rigid3> CameraMotion(const CameraMotionOptions& options,
                                   const SmallCamera& camera,
                                   const SmallFrame& a,
                                   const SmallFrame& b,
                                   std::uint64_t seed);

}  // namespace nightmap
