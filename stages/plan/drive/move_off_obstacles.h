// SPDX-License-Identifier: Apache-2.0
// Moves a planned path away from obstacles: it may pass them at exactly the robot's radius, and no
// robot follows a path that exactly.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/plan/drive/clearance_map.h"

namespace nightmap {

// Samples the path every few centimetres. Points with less room than `margin_m` move up the
// gradient of the clearance until they have it or are midway between obstacles. No point moves by
// more; the ends stay, and points near an end move less, so that the path stays smooth. Clearance
// never falls. Deterministic.
std::vector<Eigen::Vector2d> MoveOffObstacles(const ClearanceMap& map,
                                              const std::vector<Eigen::Vector2d>& path,
                                              double margin_m);

}  // namespace nightmap
