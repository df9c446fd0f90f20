// SPDX-License-Identifier: Apache-2.0
// Truth about the things in the synthetic building: what furniture stands where.
#pragma once

#include <array>
#include <vector>

#include "pipeline/world/scene.h"

namespace nightmap {

inline constexpr std::array<SurfaceLabel, 6> kThingLabels = {SurfaceLabel::kTable,
                                                             SurfaceLabel::kChair,
                                                             SurfaceLabel::kShelf,
                                                             SurfaceLabel::kCabinet,
                                                             SurfaceLabel::kBed,
                                                             SurfaceLabel::kSofa};
bool IsThingLabel(SurfaceLabel label);

// A thing is what one piece has of one of kThingLabels; a desk is a table, a cabinet and a chair.
// Each is given as one upright box around its boxes, which has the axes of the largest of them: a
// chair is turned in its piece. In order of the pieces, then of the labels.
std::vector<Box> TrueThings(const std::vector<Box>& boxes);

}  // namespace nightmap
