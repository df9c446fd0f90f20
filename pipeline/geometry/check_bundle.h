// SPDX-License-Identifier: Apache-2.0
// What a bundle adjustment may begin with.
#pragma once

#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {

// For whoever made a map that cannot be adjusted.
inline constexpr const char* kBundleRemedy =
    "delete the odometry folder of this site and run make; if it comes back, check "
    "depth_units_per_m and the intrinsics in the site config";

// Throws DataError when sizes do not fit, or a pose, point or observation is no number.
void CheckBundle(const BundleProblem& problem);

}  // namespace nightmap
