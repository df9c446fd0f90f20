// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/cell_walk.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "pipeline/base/random.h"

namespace nightmap::cell_walk_test {

using Cell = std::pair<int, int>;

std::vector<Cell> Walk(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  std::vector<Cell> cells;
  WalkCells(from, to, [&](const Eigen::Vector2i& cell) { cells.emplace_back(cell.x(), cell.y()); });
  return cells;
}

// Cells that the line crosses over at least `min_length`, by the part of the line in each cell.
std::set<Cell> CellsByClipping(const Eigen::Vector2d& from,
                               const Eigen::Vector2d& to,
                               double min_length) {
  std::set<Cell> cells;
  const Eigen::Vector2d way = to - from;
  const Eigen::Vector2i low = from.cwiseMin(to).array().floor().cast<int>();
  const Eigen::Vector2i high = from.cwiseMax(to).array().floor().cast<int>();
  for (int x = low.x(); x <= high.x(); ++x) {
    for (int y = low.y(); y <= high.y(); ++y) {
      const Eigen::Array2d a = (Eigen::Vector2d(x, y) - from).array() / way.array();
      const Eigen::Array2d b = (Eigen::Vector2d(x + 1, y + 1) - from).array() / way.array();
      const double enter = std::max(0.0, a.min(b).maxCoeff());
      const double leave = std::min(1.0, a.max(b).minCoeff());
      if ((leave - enter) * way.norm() >= min_length) cells.insert({x, y});
    }
  }
  return cells;
}

TEST(CellWalk, VisitsTheCellsOfTheLineAndNoOthers) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const auto point = [&] {
      return Eigen::Vector2d(random.Uniform() * 60 - 30, random.Uniform() * 60 - 30);
    };
    const Eigen::Vector2d from = point(), to = point();
    const auto cells = Walk(from, to);
    const std::set<Cell> visited(cells.begin(), cells.end());
    EXPECT_EQ(visited.size(), cells.size()) << "no cell twice";
    EXPECT_EQ(visited, CellsByClipping(from, to, 1e-9)) << "line " << i;
    // The same by points along the line, which miss cells that it only grazes.
    constexpr int kNumPoints = 20'000;
    for (int k = 0; k <= kNumPoints; ++k) {
      const Eigen::Vector2d sample = from + (to - from) * k / kNumPoints;
      EXPECT_TRUE(visited.contains(
          {static_cast<int>(std::floor(sample.x())), static_cast<int>(std::floor(sample.y()))}));
    }
  }
}

TEST(CellWalk, ConsecutiveCellsShareAnEdgeFromTheFirstToTheLast) {
  for (const Eigen::Vector2d& to : std::vector<Eigen::Vector2d>{
           {4, 4}, {-3, 3}, {-2.5, -2.5}, {0.5, 7.5}, {-6.5, 0.5}, {5, -2}}) {
    const auto cells = Walk({0.5, 0.5}, to);
    EXPECT_EQ(cells.front(), Cell(0, 0));
    EXPECT_EQ(cells.back(), Cell(std::floor(to.x()), std::floor(to.y())));
    for (std::size_t i = 1; i < cells.size(); ++i) {
      EXPECT_EQ(std::abs(cells[i].first - cells[i - 1].first) +
                    std::abs(cells[i].second - cells[i - 1].second),
                1);
    }
  }
  EXPECT_EQ(Walk({2.5, 3.5}, {2.5, 3.5}), std::vector<Cell>({{2, 3}}));
}

}  // namespace nightmap::cell_walk_test
