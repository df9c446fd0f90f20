// SPDX-License-Identifier: Apache-2.0
// Directions that may be up, by what stands upright in a building and by how the camera turned.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "stages/dense/map_frame/surface_patches.h"

namespace nightmap {

// Turns `up`, of unit length, until surfaces are parallel or perpendicular to it, as floors and
// walls are: the least squares over both sets, with a shrinking tolerance (Gupta, Arbelaez and
// Malik, Perceptual Organization and Recognition of Indoor Scenes from RGB-D Images, CVPR 2013).
// `up` itself where the surfaces do not determine it. Deterministic.
Eigen::Vector3d AlignToSurfaces(const std::vector<SurfacePatch>& patches,
                                const Eigen::Vector3d& up);

// Unit vectors in the given frame, each aligned to the surfaces and at least kSameUp_rad from the
// others: both ways along the main directions of the surfaces, along what is perpendicular to two
// of them, and along the axis about which the robot turned. `first` comes first, as it is.
std::vector<Eigen::Vector3d> UpCandidates(const std::vector<SurfacePatch>& patches,
                                          const std::vector<Rigid3>& given_from_robots,
                                          const Eigen::Vector3d& first);

inline constexpr double kSameUp_rad = 0.17;

}  // namespace nightmap
