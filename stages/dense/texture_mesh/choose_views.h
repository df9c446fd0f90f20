// SPDX-License-Identifier: Apache-2.0
// One view for each triangle, the same for neighbours where that costs little; and the charts.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/dense/mesh_io.h"
#include "stages/dense/texture_mesh/find_views.h"

namespace nightmap {

// The triangles across the three edges of each; itself where there is none.
std::vector<std::array<std::uint32_t, 3>> NeighborsOf(const std::vector<Triangle>& triangles);

// The view of each triangle, or kNoView. Views that have at least half the score of a triangle's
// best are as good: the view that is as good for most triangles without one gets these, until all
// have one. Then a triangle takes the view of two neighbours that is as good for it.
std::vector<std::uint32_t> ChooseViews(const std::vector<BestViews>& found,
                                       const std::vector<std::array<std::uint32_t, 3>>& neighbors);

// Triangles that hang together and have the same view; in order of the first triangle.
struct ViewChart {
  std::uint32_t view = kNoView;
  std::vector<std::uint32_t> triangles;  // ascending
};
std::vector<ViewChart> ChartsOf(const std::vector<std::uint32_t>& views,
                                const std::vector<std::array<std::uint32_t, 3>>& neighbors);

}  // namespace nightmap
