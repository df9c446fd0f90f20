// SPDX-License-Identifier: Apache-2.0
// Where up is and where the floor lies, from what the depth images see.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "stages/map_frame/map_frame.h"
#include "stages/map_frame/surface_patches.h"

namespace nightmap {

// Up: `up_in_given` of an accelerometer if given, else the mean of the cameras' up axes; refined to
// the common normal of the surfaces that face it. Floor: as of ChooseFloor, the lowest level
// surface below the cameras. The map's origin is below the first camera, its x axis along the first
// camera's view. Deterministic.
MapFrame FindMapFrame(const MapFrameOptions& options,
                      const std::vector<SurfacePatch>& patches,
                      const std::vector<Rigid3>& given_from_cameras,
                      const std::optional<Eigen::Vector3d>& up_in_given);

}  // namespace nightmap
