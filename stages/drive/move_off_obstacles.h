// SPDX-License-Identifier: Apache-2.0
// A planned path may touch obstacles with the robot's rim; no robot follows it so exactly.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/drive/clearance.h"

namespace nightmap {

// The path with points every few centimetres, those with less than `margin_m` between robot and
// obstacle moved away from it, up the gradient of the clearance, until they have it or are in the
// middle between obstacles. No point moves by more than margin_m, the ends not at all, and points
// near an end by less, so that the path stays smooth. Clearance never falls. Deterministic.
std::vector<Eigen::Vector2d> MoveOffObstacles(const ClearanceMap& map,
                                              const std::vector<Eigen::Vector2d>& path,
                                              double margin_m);

}  // namespace nightmap
