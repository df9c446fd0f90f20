// SPDX-License-Identifier: Apache-2.0
// Finds the up direction and the floor's height from depth images.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "stages/dense/map_frame/map_frame.h"
#include "stages/dense/map_frame/surface_patches.h"

namespace nightmap {

// The mount of the cameras, and the measured up if there is one.
struct UpInput {
  std::vector<Rigid3> given_from_robots;  // of the keyframes; robot: x forward, y left, z up
  // Whether a site config says how the camera is mounted. Else the robot is a person who holds the
  // camera level and upright.
  bool is_mount_stated = false;
  std::optional<Eigen::Vector3d> measured_in_given;  // of an accelerometer
};

// Up is what an accelerometer measured if there is one, else what ChooseUp finds likeliest, with
// the robots' mean z axis as guess. It is refined to the common normal of the surfaces that face
// up. The floor is the lowest level surface below the cameras, see ChooseFloor. The map's origin is
// below the first camera, and its x axis follows the first camera's view. Deterministic.
MapFrame FindMapFrame(const MapFrameOptions& options,
                      const std::vector<SurfacePatch>& patches,
                      const std::vector<Rigid3>& given_from_cameras,
                      const UpInput& input);

}  // namespace nightmap
