// SPDX-License-Identifier: Apache-2.0
// Paths from cell to cell, for the tests of what makes them better.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/stages/plan/plan/reference_path.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap {

// test(map, path) for the cheapest path between random ends of each of 300 small random maps, where
// there is one.
inline void ForRandomRoutes(const std::function<void(const CostMap&, const Points&)>& test) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    Random random(seed, 1);
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const auto search = FindPath(map, start, goal, Steps::kCellToCell);
    if (!search.found) continue;
    const Points path = Centres(search.cells);
    ASSERT_TRUE(std::isfinite(CostOf(map, path)));
    test(map, path);
  }
}

}  // namespace nightmap
