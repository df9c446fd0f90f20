// SPDX-License-Identifier: Apache-2.0
// Uncertainty that the map's own error adds to that of a pose in it.
#pragma once

#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "stages/camera/localize/judge_places.h"

namespace nightmap {

// Covariance of a left perturbation (rotation rad, translation m) of camera_from_map. The landmarks
// of one place were seen from the same keyframes and share their error, so more of them do not make
// it smaller: the place is off by the standard deviation of its median inlier, in each direction,
// and turned by that over the median distance from the camera. Zero without inliers.
Matrix6d MapCovariance(const Place& place);

}  // namespace nightmap
