// SPDX-License-Identifier: Apache-2.0
// Finds the up direction and the floor's height from depth images.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "stages/map_frame/map_frame.h"
#include "stages/map_frame/surface_patches.h"

namespace nightmap {

// Up is `up_in_given` of an accelerometer if given, else the mean of the cameras' up axes; both are
// refined to the common normal of the surfaces that face up. The floor is the lowest level surface
// below the cameras, see ChooseFloor. The map's origin is below the first camera, and its x axis
// follows the first camera's view. Deterministic.
MapFrame FindMapFrame(const MapFrameOptions& options,
                      const std::vector<SurfacePatch>& patches,
                      const std::vector<Rigid3>& given_from_cameras,
                      const std::optional<Eigen::Vector3d>& up_in_given);

}  // namespace nightmap
