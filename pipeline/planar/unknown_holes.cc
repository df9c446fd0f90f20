// SPDX-License-Identifier: Apache-2.0
#include "pipeline/planar/unknown_holes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace nightmap {
namespace {

constexpr double kRounding = 1e-6;  // cells

// Side of the largest square of unknown cells whose upper right cell is this one, in cells.
std::vector<int> SquaresOfUnknown(const OccupancyGrid& grid) {
  std::vector<int> sides(grid.cells.size(), 0);
  const auto side = [&](int x, int y) { return x < 0 || y < 0 ? 0 : sides[grid.Index(x, y)]; };
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (grid.At({x, y}) != kUnknownCell) continue;
      const int least = std::min({side(x - 1, y), side(x, y - 1), side(x - 1, y - 1)});
      sides[grid.Index(x, y)] = least + 1;
    }
  }
  return sides;
}

// Visits the parts of unknown cells one after the other.
class UnknownParts {
 public:
  UnknownParts(const OccupancyGrid& grid, int max_cells)
      : grid_(grid),
        max_cells_(max_cells),
        squares_(SquaresOfUnknown(grid)),
        is_visited_(grid.cells.size(), 0) {}

  // The cells of the part that holds a cell, if it is a hole that was not visited; else none.
  std::vector<std::size_t> HoleFrom(std::size_t seed) {
    if (!IsNew(seed)) return {};
    is_hole_ = true;
    part_ = {seed};
    is_visited_[seed] = 1;
    for (std::size_t i = 0; i < part_.size(); ++i) Visit(part_[i]);
    return is_hole_ ? part_ : std::vector<std::size_t>();
  }

 private:
  bool IsNew(std::size_t cell) const {
    return grid_.cells[cell] == kUnknownCell && is_visited_[cell] == 0;
  }

  void Visit(std::size_t cell) {
    if (squares_[cell] > max_cells_) is_hole_ = false;
    const int column = static_cast<int>(cell % static_cast<std::size_t>(grid_.width));
    const int row = static_cast<int>(cell / static_cast<std::size_t>(grid_.width));
    for (int y = row - 1; y <= row + 1; ++y) {
      for (int x = column - 1; x <= column + 1; ++x) VisitNeighbour({x, y});
    }
  }

  void VisitNeighbour(const Eigen::Vector2i& cell) {
    if (!grid_.Contains(cell) || grid_.At(cell) == kOccupiedCell) {
      is_hole_ = false;
      return;
    }
    const std::size_t index = grid_.Index(cell.x(), cell.y());
    if (!IsNew(index)) return;
    is_visited_[index] = 1;
    part_.push_back(index);
  }

  const OccupancyGrid& grid_;
  int max_cells_;
  std::vector<int> squares_;
  std::vector<std::uint8_t> is_visited_;
  std::vector<std::size_t> part_;
  bool is_hole_ = true;
};

}  // namespace

std::vector<std::size_t> FindUnknownHoles(const OccupancyGrid& grid, double max_width_m) {
  std::vector<std::size_t> holes;
  const double max_cells = std::floor(max_width_m / grid.resolution_m + kRounding);
  if (max_cells < 1) return holes;
  UnknownParts parts(grid, static_cast<int>(std::min(max_cells, 1e6)));
  for (std::size_t cell = 0; cell < grid.cells.size(); ++cell) {
    const auto hole = parts.HoleFrom(cell);
    holes.insert(holes.end(), hole.begin(), hole.end());
  }
  std::ranges::sort(holes);
  return holes;
}

OccupancyGrid WithHolesFree(OccupancyGrid grid, double max_width_m) {
  for (const std::size_t cell : FindUnknownHoles(grid, max_width_m)) grid.cells[cell] = kFreeCell;
  return grid;
}

}  // namespace nightmap
