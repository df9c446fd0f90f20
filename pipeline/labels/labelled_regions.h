// SPDX-License-Identifier: Apache-2.0
// Regions that may move by their labels: one for each thing, as far as labels and depth tell.
#pragma once

#include <cstdint>

#include "pipeline/io/image_io.h"

namespace nightmap {

struct LabelledRegions {
  Image<std::int32_t> of_pixel;  // 0: none, else 1 .. num
  int num = 0;
};

// Neighbouring pixels of `may_move` (not 0) are of one region unless a step in depth of more than
// a tenth of the nearer is between them. Pixels without depth join the region
// that reaches them first, and lead only to others without: a shadow between two people joins them
// not. Regions are numbered by their first pixel, row by row. Both pictures have one size.
// Deterministic.
LabelledRegions FindLabelledRegions(const GrayImage& may_move, const DepthImage& depth);

}  // namespace nightmap
