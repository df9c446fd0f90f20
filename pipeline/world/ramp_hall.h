// SPDX-License-Identifier: Apache-2.0
// The hall with the ramp that joins two storeys: two parallel lanes, west of the building. One goes
// north from a landing up to a half landing; the other goes back south to the upper landing, above
// the lower one. A passage leads from each landing into the west corridor.
#pragma once

#include <optional>

#include "pipeline/world/scene_builder.h"
#include "pipeline/world/synthetic_options.h"

namespace nightmap {

struct RampHall {
  Rect2 landing;       // of both storeys
  Rect2 up;            // the western lane, from the lower landing
  Rect2 half_landing;  // half a storey up
  Rect2 down;          // the eastern lane, from the upper landing
  Rect2 passage;       // the gap in the corridor's wall, on both storeys
  double storey_m = 0;

  // Height of the ground on a lane or the half landing; nothing elsewhere, landings included.
  std::optional<double> RampHeight_m(double x, double y) const;
};

// `corridor` is the corridor's western part, `extent` the building without the hall.
RampHall PlanRampHall(const BuildingOptions& options, const Rect2& corridor, const Rect2& extent);

// Builds ground, walls, ceiling, lamps and posters of the hall. Storeys are as high as the options
// say, and the slab between them fills the rest. The corridor's wall is not part of the hall.
void BuildRampHall(const RampHall& hall,
                   const BuildingOptions& options,
                   const Rect2& corridor,
                   SceneBuilder& builder);

}  // namespace nightmap
