// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/cube_cases.h"

#include <pcl/surface/marching_cubes.h>

#include <algorithm>
#include <iterator>

namespace nightmap {

std::span<const int> EdgesOfTriangles(unsigned corners_behind) {
  const auto& edges = pcl::triTable[corners_behind];
  return {std::begin(edges), std::ranges::find(edges, -1)};
}

}  // namespace nightmap
