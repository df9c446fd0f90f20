// SPDX-License-Identifier: Apache-2.0
// Fittings of real ceilings beside tiles and lamps: vents, hatches, tiles of another tone, smoke
// detectors and sprinklers, at irregular places.
#pragma once

#include "pipeline/base/random.h"
#include "pipeline/world/floor_layout.h"
#include "pipeline/world/scene_builder.h"

namespace nightmap {

// Adds flat fittings just below the ceiling of a rectangle, `per_m2` of them or as many as find
// room beside its lamps. Edges are parallel to x and y. Surfaces have the label of the ceiling.
// `random` alone decides kinds and places.
void FitCeiling(
    const Rect2& rect, double ceiling_m, double per_m2, Random random, SceneBuilder& builder);

// Fits the ceilings of the corridor and all rooms. Call it when the lamps are there.
void FitCeilings(const FloorLayout& layout, const BuildingOptions& options, SceneBuilder& builder);

}  // namespace nightmap
