// SPDX-License-Identifier: Apache-2.0
// The ways that walls do not tell: wheels tell them, at the scale that they have where walls do.
#pragma once

#include <optional>
#include <vector>

#include "stages/laser/scan_match/scan_match.h"

namespace nightmap {

// Metres of the walls over metres of the wheels, by least squares over windows of kScaleWindow_s in
// which walls hold the robot in all directions (Censi, Franchi, Marchionni, Oriolo, Simultaneous
// calibration of odometry and sensor parameters for mobile robots, IEEE T-RO 2013, estimate more).
// None where it would not be known to a hundredth. Pure.
inline constexpr double kScaleWindow_s = 2;
std::optional<double> WheelScale(const std::vector<MatchedScan>& scans);

// Scales the ways along unclear directions by `scale`, and moves along all that comes after. Pure.
void ScaleUnclearWays(double scale, std::vector<MatchedScan>* scans);

// Covariance of the motion from one scan to the next one, along the direction that is unclear in
// the latter: 0.1 m after a metre, as wheels that drift at random do. Their scale errs for longer
// ways alike, so this is more than their noise. In the axes of the latter.
Eigen::Matrix3d UnclearCovariance(const MatchedScan& last, const MatchedScan& scan);

}  // namespace nightmap
