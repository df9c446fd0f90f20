// SPDX-License-Identifier: Apache-2.0
// Puts furniture into the rooms and pictures onto the walls.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/world/floor_layout.h"
#include "pipeline/world/scene_builder.h"

namespace nightmap {

// Nothing comes nearer than `clearance_m` to the route, or into another box. Rooms of equal style
// get equal furniture and pictures; their floors and door signs differ.
void Furnish(const FloorLayout& layout,
             const BuildingOptions& options,
             const std::vector<Eigen::Vector2d>& route,
             double clearance_m,
             SceneBuilder& builder);

}  // namespace nightmap
