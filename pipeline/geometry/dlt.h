// SPDX-License-Identifier: Apache-2.0
// Camera pose by the direct linear transform (Hartley and Zisserman, Multiple View Geometry, 2004,
// section 7.1, the points normalized as there; rays need it less).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

constexpr int kDltSampleSize = 6;

// camera_from_world of at least six points (metres) seen at `rays` (x/z and y/z in the camera, no
// distortion). The 3 x 4 matrix is solved linearly, then its left part is replaced by the nearest
// rotation, so the pose is exact for exact input and no least-squares solution otherwise. Nothing
// when the points do not determine the matrix (all on a plane, or on a twisted cubic with the
// camera) or lie behind the camera. Throws std::invalid_argument when the lists do not fit.
std::optional<Rigid3> SolveDlt(const std::vector<Eigen::Vector2d>& rays,
                               const std::vector<Eigen::Vector3d>& points_in_world);

}  // namespace nightmap
