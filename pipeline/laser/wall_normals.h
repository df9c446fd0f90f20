// SPDX-License-Identifier: Apache-2.0
// Points of a scan that lie on a wall, and where that wall faces.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nightmap {

// The unit normal of the wall through each point, and zero where there is none: a point is on a
// wall when it is one of kWallPoints neighbours in the order of the beams that lie on a line, with
// a root mean square distance from it of at most max_rms_m. Pure.
inline constexpr int kWallPoints = 7;
std::vector<Eigen::Vector2d> WallNormals(const std::vector<Eigen::Vector2d>& points,
                                         double max_rms_m);

}  // namespace nightmap
