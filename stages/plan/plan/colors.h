// SPDX-License-Identifier: Apache-2.0
// Colors that all pictures of a plan share.
#pragma once

#include "pipeline/plan/draw_on_grid.h"

namespace nightmap {

constexpr Rgb kStartColor = {20, 150, 60};
constexpr Rgb kGoalColor = {210, 40, 40};
constexpr Rgb kInkColor = {30, 30, 30};

}  // namespace nightmap
