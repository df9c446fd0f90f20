// SPDX-License-Identifier: Apache-2.0
// The layout of the active state of CeilingFilter.
#pragma once

#include <Eigen/Core>

namespace nightmap {

// Where the parts begin; clones and landmarks follow in the order in which they were added.
inline constexpr Eigen::Index kAnchor = 0;        // x, y (m), heading (rad) in the map
inline constexpr Eigen::Index kRobot = 3;         // x, y (m), heading (rad) in the anchor's frame
inline constexpr Eigen::Index kVibration = 6;     // tilt of this frame alone (2, rad)
inline constexpr Eigen::Index kScale = 8;         // true distance = (1 + this) measured distance
inline constexpr Eigen::Index kHeadingError = 9;  // rad per m that the wheels do not count
inline constexpr Eigen::Index kMounting = 10;     // tilt of the camera on the robot (2, rad)
inline constexpr Eigen::Index kNumFixed = 12;
inline constexpr Eigen::Index kCloneSize = 5;     // robot and vibration of an earlier frame
inline constexpr Eigen::Index kLandmarkSize = 3;  // m, in the anchor's frame
// Values that are exact by definition have this variance, so that the covariance stays positive
// definite: 10 um, 10 urad.
inline constexpr double kExactVariance = 1e-10;

}  // namespace nightmap
