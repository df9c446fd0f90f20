// SPDX-License-Identifier: Apache-2.0
// Brings probabilities from a network's resolution to that of the picture, along its edges.
#pragma once

#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

// A plane of floats, row by row.
using Plane = Image<float>;

// Fast guided filter (He and Sun 2015): in each window of the small planes, fits a plane's values
// by a linear function of color and inverse depth, and applies the means of these functions to the
// pixels of the picture. Where planes sum to 1 their results do. `small` have one size; the results
// have that of `color`. `depth` is metres at the color pixels, 0 = not measured, or empty. Linear
// in `small` and deterministic.
std::vector<Plane> UpsampleAlongEdges(const std::vector<Plane>& small,
                                      const ColorImage& color,
                                      const DepthImage& depth);

}  // namespace nightmap
