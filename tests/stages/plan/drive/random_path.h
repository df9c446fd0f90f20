// SPDX-License-Identifier: Apache-2.0
// Random buildings and random paths in them that a round robot fits on, some of them barely.
#pragma once

#include <algorithm>
#include <deque>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/io/grid_io.h"
#include "stages/plan/drive/drive.h"
#include "tests/small_grids.h"

namespace nightmap {

// Rooms of three to four metres with doors just wide enough, and boxes in them. Cells of 0.05 m.
inline OccupancyGrid RandomBuilding(Random& random, int side = 150) {
  OccupancyGrid grid = FreeGrid(side, side, 0.05, {-2.5, 1.25});
  const auto fill = [&](int x0, int y0, int width, int height, CellValue value) {
    FillCells(x0, y0, x0 + width, y0 + height, value, &grid);
  };
  const auto draw = [&](int first, int last) {
    return first + static_cast<int>(random.Index(static_cast<std::size_t>(last - first + 1)));
  };
  const int room = draw(60, 80);
  for (int at = 0; at < side; at += room) {
    fill(at, 0, 2, side, kOccupiedCell);
    fill(0, at, side, 2, kOccupiedCell);
  }
  for (int y = 0; y < side; y += room) {
    for (int x = 0; x < side; x += room) {
      fill(x, y + draw(8, room - 30), 2, draw(12, 20), kFreeCell);
      fill(x + draw(8, room - 30), y, draw(12, 20), 2, kFreeCell);
      const int num_boxes = draw(2, 8);
      for (int i = 0; i < num_boxes; ++i) {
        const CellValue value = i % 3 == 0 ? kUnknownCell : kOccupiedCell;
        fill(x + draw(0, room), y + draw(0, room), draw(1, 14), draw(1, 14), value);
      }
    }
  }
  return grid;
}

// Breadth first from one random place to another, then shortcuts wherever a straight line keeps the
// radius: what any planner might give, without its distance from obstacles. Empty when the second
// place is out of reach.
class RandomPaths {
 public:
  RandomPaths(const OccupancyGrid& grid, double radius_m)
      : grid_(grid), map_(grid, {radius_m, true}), free_(grid.cells.size()) {
    for (std::size_t i = 0; i < free_.size(); ++i) {
      free_[i] = map_.IsClear(grid_.CenterInMap(CellAt(i))) ? 1 : 0;
    }
  }

  std::vector<Eigen::Vector2d> Draw(Random& random) const {
    std::vector<Eigen::Vector2d> path = Search(DrawFree(random), DrawFree(random));
    for (int i = 0; i < 200 && path.size() > 2; ++i) {
      const std::size_t a = random.Index(path.size() - 1);
      const std::size_t b = a + 1 + random.Index(path.size() - a - 1);
      if (!IsLineClear(path[a], path[b])) continue;
      path.erase(path.begin() + static_cast<std::ptrdiff_t>(a) + 1,
                 path.begin() + static_cast<std::ptrdiff_t>(b));
    }
    return path;
  }

  // Between robot and obstacles, at its least along a path.
  double Room_m(const std::vector<Eigen::Vector2d>& path) const {
    double room_m = map_.Room_m(path[0]);
    for (std::size_t i = 1; i < path.size(); ++i) {
      for (int k = 1; k <= 100; ++k) {
        const Eigen::Vector2d point = path[i - 1] + (path[i] - path[i - 1]) * k / 100;
        room_m = std::min(room_m, map_.Room_m(point));
      }
    }
    return room_m;
  }

 private:
  Eigen::Vector2i CellAt(std::size_t index) const {
    const auto width = static_cast<std::size_t>(grid_.width);
    return {static_cast<int>(index % width), static_cast<int>(index / width)};
  }
  std::size_t DrawFree(Random& random) const {
    while (true) {
      const std::size_t index = random.Index(free_.size());
      if (free_[index] != 0) return index;
    }
  }
  std::vector<Eigen::Vector2d> Search(std::size_t start, std::size_t goal) const {
    std::vector<std::size_t> previous(free_.size(), free_.size());
    std::deque<std::size_t> open = {goal};
    previous[goal] = goal;
    while (!open.empty() && previous[start] == free_.size()) {
      const std::size_t from = open.front();
      open.pop_front();
      for (const Eigen::Vector2i& step : {Eigen::Vector2i(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const Eigen::Vector2i cell = CellAt(from) + step;
        if (!grid_.Contains(cell)) continue;
        const std::size_t index = grid_.Index(cell.x(), cell.y());
        if (free_[index] == 0 || previous[index] != free_.size()) continue;
        previous[index] = from;
        open.push_back(index);
      }
    }
    std::vector<Eigen::Vector2d> path;
    if (previous[start] == free_.size()) return path;
    for (std::size_t at = start; path.empty() || at != goal;) {
      if (!path.empty()) at = previous[at];
      path.push_back(grid_.CenterInMap(CellAt(at)));
    }
    return path;
  }
  bool IsLineClear(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const int num_steps = 1 + static_cast<int>((to - from).norm() / 0.01);
    for (int i = 0; i <= num_steps; ++i) {
      if (!map_.IsClear(from + (to - from) * i / num_steps)) return false;
    }
    return true;
  }

  OccupancyGrid grid_;
  ClearanceMap map_;
  std::vector<std::uint8_t> free_;
};

}  // namespace nightmap
