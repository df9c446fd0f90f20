// SPDX-License-Identifier: Apache-2.0
// Camera pose by the direct linear transform (Hartley and Zisserman, Multiple View Geometry, 2004,
// section 7.1). Normalizes only the points, because rays are nearly normalized already.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

constexpr int kDltSampleSize = 6;

// camera_from_world from at least six points (metres) seen at `rays` (x/z and y/z in the camera, no
// distortion). Solves the 3 x 4 matrix linearly, then replaces its left part by the nearest
// rotation; so the pose is exact for exact input but is no least-squares solution otherwise.
// Returns nothing when the points do not determine the matrix (all on a plane, or on a twisted
// cubic with the camera) or lie behind the camera. Throws std::invalid_argument when the lists
// differ in length.
std::optional<Rigid3> SolveDlt(const std::vector<Eigen::Vector2d>& rays,
                               const std::vector<Eigen::Vector3d>& points_in_world);

}  // namespace nightmap
