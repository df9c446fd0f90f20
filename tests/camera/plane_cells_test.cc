// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/plane_cells.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/random.h"

namespace nightmap::plane_cells_test {

std::vector<Eigen::Vector2d> Positions(std::size_t count) {
  Random random(5);
  std::vector<Eigen::Vector2d> positions;
  for (std::size_t i = 0; i < count; ++i) {
    positions.emplace_back(random.Uniform(-20, 40), 3 * random.Gaussian());
  }
  return positions;
}

TEST(CutPlane, CellsPartitionThePlaneAndHoldWhatTheySay) {
  const auto positions = Positions(2000);
  const auto cells = CutPlane(positions, 100, 0.1);
  EXPECT_GE(cells.size(), 20U);
  std::vector<std::size_t> counts(cells.size(), 0);
  for (const Eigen::Vector2d& position : positions) {
    std::size_t num_holding = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (!cells[i].box.Contains(position)) continue;
      ++num_holding;
      ++counts[i];
    }
    EXPECT_EQ(num_holding, 1U);
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    EXPECT_EQ(counts[i], cells[i].num_positions);
    EXPECT_LE(counts[i], 100U);
    EXPECT_GE(counts[i], 40U);
  }
  for (const Eigen::Vector2d& far : {Eigen::Vector2d(1e6, -1e6), Eigen::Vector2d(-1e6, 0)}) {
    EXPECT_EQ(std::ranges::count_if(cells, [&](const auto& c) { return c.box.Contains(far); }), 1);
  }
}

TEST(CutPlane, OrderDoesNotMatter) {
  auto positions = Positions(500);
  const auto cells = CutPlane(positions, 50, 0.1);
  std::ranges::reverse(positions);
  const auto again = CutPlane(positions, 50, 0.1);
  ASSERT_EQ(again.size(), cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    EXPECT_EQ(again[i].box.min_m, cells[i].box.min_m);
    EXPECT_EQ(again[i].box.max_m, cells[i].box.max_m);
  }
}

TEST(CutPlane, FewAreOneCell) {
  for (const auto& positions : {Positions(0), Positions(50)}) {
    const auto cells = CutPlane(positions, 50, 0.1);
    ASSERT_EQ(cells.size(), 1U);
    EXPECT_FALSE(cells[0].box.IsBounded());
    EXPECT_EQ(cells[0].num_positions, positions.size());
  }
}

TEST(CutPlane, ManyInOnePlaceStayTogether) {
  std::vector<Eigen::Vector2d> positions(300, Eigen::Vector2d(1, 2));
  EXPECT_EQ(CutPlane(positions, 10, 0).size(), 1U);
  positions.emplace_back(3, 2);
  const auto cells = CutPlane(positions, 10, 0);
  ASSERT_EQ(cells.size(), 2U);
  EXPECT_EQ(cells[0].num_positions, 300U);
  EXPECT_EQ(CutPlane(positions, 10, 2.5).size(), 1U);
}

}  // namespace nightmap::plane_cells_test
