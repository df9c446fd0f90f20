// SPDX-License-Identifier: Apache-2.0
// The area of the map, seen from above, in which a camera may see something.
#pragma once

#include <array>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rectangle.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

// The pyramid of everything that a camera sees up to a depth: its tip at the camera, then the
// corners of its base, in the camera's frame. Accounts for distortion.
using ViewPyramid = std::array<Eigen::Vector3d, 5>;
ViewPyramid MakeViewPyramid(const Camera& camera, double max_depth_m);

// The outline of the pyramid on the map is the convex hull of these points.
using ViewFootprint = std::array<Eigen::Vector2d, 5>;
ViewFootprint ProjectToMap(const ViewPyramid& pyramid, const Rigid3& map_from_camera);

// Whether the convex hull of the points intersects the rectangle (separating axis theorem:
// Gottschalk, Lin, Manocha, OBBTree, 1996).
bool Touches(const ViewFootprint& footprint, const Rectangle& rectangle);

}  // namespace nightmap
