// SPDX-License-Identifier: Apache-2.0
// Checks the input of a bundle adjustment.
#pragma once

#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {

// Remedy for the user whose map cannot be adjusted.
inline constexpr const char* kBundleRemedy =
    "delete the odometry folder of this site and run make; if it comes back, check "
    "depth_units_per_m and the intrinsics in the site config";

// Throws DataError when sizes do not fit, or a pose, point or observation is not a number.
void CheckBundle(const BundleProblem& problem);

}  // namespace nightmap
