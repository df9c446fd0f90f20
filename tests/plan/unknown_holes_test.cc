// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/unknown_holes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>

#include "tests/small_grids.h"

namespace nightmap::unknown_holes_test {

std::size_t NumHoleCells(const std::vector<std::string>& rows, double max_width_m = 0.2) {
  return FindUnknownHoles(GridFromText(rows), max_width_m).size();
}

TEST(UnknownHoles, AreNarrowAndHaveSeenFloorAllAround) {
  EXPECT_EQ(NumHoleCells({".....", "..?..", "....."}), 1U);
  EXPECT_EQ(NumHoleCells({".....", ".?...", "..?..", "....."}), 2U);  // joined at a corner
  EXPECT_EQ(NumHoleCells({"......", ".????.", "......"}), 4U);        // however long
  EXPECT_EQ(NumHoleCells({"......", ".????.", ".????.", "......"}), 8U);
  EXPECT_EQ(NumHoleCells({"......", ".????.", ".????.", "......"}, 0.1), 0U);
  EXPECT_EQ(NumHoleCells({".....", ".???.", ".???.", ".???.", "....."}), 0U);  // too wide
  EXPECT_EQ(NumHoleCells({".....", ".???.", ".???.", ".???.", "....."}, 0.3), 9U);
  EXPECT_EQ(NumHoleCells({".....", "..?..", "...#."}), 0U);  // beside an obstacle
  EXPECT_EQ(NumHoleCells({"..?..", "....."}), 0U);           // at the border
  EXPECT_EQ(NumHoleCells({".....", "..?..", "....."}, 0.099), 0U);
  EXPECT_EQ(NumHoleCells({".....", "..?..", "....."}, 0), 0U);
  EXPECT_EQ(FindUnknownHoles(OccupancyGrid{}, 1).size(), 0U);
}

// The parts of unknown cells, grown one by one from each cell.
std::set<std::size_t> PartOf(const OccupancyGrid& grid, std::size_t seed) {
  std::set<std::size_t> part = {seed};
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const std::size_t cell = grid.Index(x, y);
        if (grid.cells[cell] != kUnknownCell || part.contains(cell)) continue;
        const bool touches = std::ranges::any_of(part, [&](std::size_t other) {
          const int other_x = static_cast<int>(other) % grid.width;
          const int other_y = static_cast<int>(other) / grid.width;
          return std::abs(other_x - x) <= 1 && std::abs(other_y - y) <= 1;
        });
        if (touches) has_grown = part.insert(cell).second;
      }
    }
  }
  return part;
}

bool HasSquare(const OccupancyGrid& grid, std::size_t lower_left, int side) {
  for (int i = 0; i < side * side; ++i) {
    const Eigen::Vector2i cell(static_cast<int>(lower_left) % grid.width + i % side,
                               static_cast<int>(lower_left) / grid.width + i / side);
    if (!grid.Contains(cell) || grid.At(cell) != kUnknownCell) return false;
  }
  return true;
}

bool IsHole(const OccupancyGrid& grid, const std::set<std::size_t>& part, int max_cells) {
  for (const std::size_t cell : part) {
    if (HasSquare(grid, cell, max_cells + 1)) return false;
    for (int i = 0; i < 9; ++i) {
      const Eigen::Vector2i beside(static_cast<int>(cell) % grid.width + i % 3 - 1,
                                   static_cast<int>(cell) / grid.width + i / 3 - 1);
      if (!grid.Contains(beside) || grid.At(beside) == kOccupiedCell) return false;
    }
  }
  return true;
}

TEST(UnknownHoles, EqualThoseFoundCellByCell) {
  Random random(3);
  std::size_t num_holes = 0;
  for (int i = 0; i < 60; ++i) {
    OccupancyGrid grid = RandomGrid(random, 19, 14, 0.01, 0.1 + 0.1 * (i % 3));
    grid.resolution_m = 0.05;
    const int max_cells = 1 + i % 2;
    std::vector<std::size_t> expected;
    for (std::size_t cell = 0; cell < grid.cells.size(); ++cell) {
      if (grid.cells[cell] != kUnknownCell) continue;
      if (IsHole(grid, PartOf(grid, cell), max_cells)) expected.push_back(cell);
    }
    EXPECT_EQ(FindUnknownHoles(grid, 0.05 * max_cells), expected);
    num_holes += expected.size();
    const OccupancyGrid filled = WithHolesFree(grid, 0.05 * max_cells);
    for (std::size_t cell = 0; cell < grid.cells.size(); ++cell) {
      const bool is_hole = std::ranges::binary_search(expected, cell);
      EXPECT_EQ(filled.cells[cell], is_hole ? std::uint8_t{kFreeCell} : grid.cells[cell]);
    }
  }
  EXPECT_GT(num_holes, 100U);
}

}  // namespace nightmap::unknown_holes_test
