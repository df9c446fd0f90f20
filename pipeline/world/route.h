// SPDX-License-Identifier: Apache-2.0
// The robot's drive: along the corridor loop, into every room, once around in it, and back to the
// start. Smooth in position and heading, closed, and far enough from walls to be driven.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/world/floor_layout.h"
#include "pipeline/world/synthetic_options.h"

namespace nightmap {

struct RoutePoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // building frame, metres
  double heading_rad = 0;  // of the camera, from +x towards +y; unwrapped along the route
  double floor_m = 0;      // height of the ground
};

// The closed path at a spacing of about 2 cm: all laps, without the overlap. The last point joins
// the first, up to whole turns of the heading. With differential_drive it heads where it leads.
std::vector<RoutePoint> PlanPath(const FloorLayout& layout, const RouteOptions& options);

// Samples num_frames points from start_ratio on, along length_ratio of the path and overlap_m
// beyond. Neighbours are equally far apart in the norm (step / max_step)^4 + (turn / max_turn)^4,
// so the camera moves slowly where it turns. Throws UsageError when num_frames is too small for the
// two limits; names the number that is enough. With points_per_frame above 1, also as many points
// less one between each frame and the next.
std::vector<RoutePoint> SampleFrames(const std::vector<RoutePoint>& path,
                                     const RouteOptions& options,
                                     int points_per_frame = 1);

// building_from_camera of a camera at a height that looks along the heading, pitched down and
// rolled about its axis.
Rigid3 CameraPose(const RoutePoint& point, double height_m, double pitch_rad, double roll_rad = 0);

// building_from_camera of every frame. Height, pitch and roll sway by a few millimetres and
// milliradians as on a real robot, unless differential_drive holds the camera still on its robot.
std::vector<Rigid3> PlanRoute(const FloorLayout& layout,
                              const RouteOptions& options,
                              const SyntheticCameraOptions& camera);

}  // namespace nightmap
