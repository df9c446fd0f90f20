// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/cell_array.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

namespace nightmap::cell_array_test {

TEST(SquareOrder, NumbersEachCellOnceAndBack) {
  for (const auto& [width, height] : {std::pair{1, 1}, {16, 16}, {15, 33}, {70, 5}, {129, 40}}) {
    const SquareOrder order(width, height);
    std::set<std::size_t> seen;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const std::size_t index = order.Index({x, y});
        EXPECT_LT(index, order.Size());
        EXPECT_TRUE(seen.insert(index).second);
        EXPECT_EQ(order.Cell(index), Eigen::Vector2i(x, y));
      }
    }
  }
}

// The purpose of the class.
TEST(SquareOrder, CellsOfASquareAreTogether) {
  const SquareOrder order(1000, 1000);
  const std::size_t first = order.Index({320, 480});
  for (int i = 0; i < 256; ++i) {
    EXPECT_EQ(order.Index({320 + i % 16, 480 + i / 16}) / 256, first / 256);
  }
}

}  // namespace nightmap::cell_array_test
