// SPDX-License-Identifier: Apache-2.0
// Walls, floors, ceilings, lamps and doors of the building.
#pragma once

#include "pipeline/world/floor_layout.h"
#include "pipeline/world/scene_builder.h"

namespace nightmap {

inline constexpr double kDoorHeight_m = 2.05;

// Frame and open leaf of a room's door, the same for every room.
void BuildDoor(const Room& room, const BuildingOptions& options, SceneBuilder& builder);

void BuildShell(const FloorLayout& layout, const BuildingOptions& options, SceneBuilder& builder);

}  // namespace nightmap
