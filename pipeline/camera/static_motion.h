// SPDX-License-Identifier: Apache-2.0
// The motion against what stands still, where a pair of frames shows several rigid motions.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/geometry/absolute_pose.h"

namespace nightmap {

// Finds rigid motions one after the other, each among the matches that fit none before it, and
// returns the one that the largest surface agrees with: what stands still (floor, walls, furniture)
// is larger than who walks before it, also where people are nearer, fill more of the picture and
// have more matches. A cell of the picture stands for the surface that it shows, (cell / focal
// length * depth)^2 in m^2; its matches share it evenly.
//
// `matches` have pixels of the target and points of the source camera (world = source). Searches on
// only while the matches without a motion stand for more surface than the best motion has, and for
// at most `max_motions`: 1 is EstimateAbsolutePose. Returns nothing when no motion has min_inliers.
// Deterministic in the seed.
[[nodiscard]] std::optional<AbsolutePose> EstimateStaticMotion(
    const Camera& camera,
    const std::vector<PointMatch>& matches,
    const AbsolutePoseOptions& options,
    int max_motions);

// The surface in m^2 that each match stands for.
std::vector<double> SurfaceAreas_m2(const Camera& camera, const std::vector<PointMatch>& matches);

}  // namespace nightmap
