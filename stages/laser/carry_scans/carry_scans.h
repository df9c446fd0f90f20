// SPDX-License-Identifier: Apache-2.0
// carry_scans: the robot's pose in the map at every scan. A graph has only the keyscans; the scans
// between them follow.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

struct CarryScansOptions {
  REGISTER_OPTIONS();
};

struct CarryScansInput {
  std::vector<StampedPose> scans;     // start_from_robot at each scan, by matching; at least one
  std::vector<StampedPose> keyscans;  // graph_from_robot, of some of these scans
};

// map_from_robot at each scan. A scan keeps the motion that matching found between it and the
// keyscans around it, and follows both in proportion (CarryFrames). The map frame is that of the
// graph, whose robot drives in the plane z = 0. Throws InputError when a keyscan is no scan, or
// when there is none. Pure.
std::vector<StampedPose> RunCarryScans(const CarryScansInput& input);

}  // namespace nightmap
