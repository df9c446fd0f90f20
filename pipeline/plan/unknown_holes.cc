// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/unknown_holes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "pipeline/base/uninitialized_vector.h"

namespace nightmap {
namespace {

constexpr double kRounding = 1e-6;  // cells

// Looks at unknown cells in the order of their indices.
class UnknownParts {
 public:
  UnknownParts(const OccupancyGrid& grid, std::uint8_t max_cells)
      : grid_(grid), max_cells_(max_cells), states_(grid.cells.size()) {
    ForUnknown([&](std::size_t cell) { states_[cell] = SquareAt(cell); });
  }

  std::vector<std::size_t> Holes() {
    std::vector<std::size_t> holes;
    ForUnknown([&](std::size_t cell) {
      if (states_[cell] > max_cells_) return;  // wide, or looked at
      if (IsHole(cell)) holes.insert(holes.end(), part_.begin(), part_.end());
    });
    std::ranges::sort(holes);
    return holes;
  }

 private:
  static constexpr std::uint8_t kOfHole = 254;
  static constexpr std::uint8_t kOfNoHole = 255;

  template <typename Visit>
  void ForUnknown(const Visit& visit) const {
    const auto& cells = grid_.cells;
    for (auto at = cells.begin();; ++at) {
      at = std::find(at, cells.end(), std::uint8_t{kUnknownCell});
      if (at == cells.end()) return;
      visit(static_cast<std::size_t>(at - cells.begin()));
    }
  }

  // Side of the largest square of unknown cells whose upper right cell is this one, in cells, at
  // most one more than a hole may have.
  std::uint8_t SquareAt(std::size_t cell) const {
    const auto width = static_cast<std::size_t>(grid_.width);
    if (cell < width || cell % width == 0) return 1;
    const auto side = [&](std::size_t other) {
      return grid_.cells[other] == kUnknownCell ? states_[other] : std::uint8_t{0};
    };
    const int least = std::min({side(cell - 1), side(cell - width), side(cell - width - 1)});
    return static_cast<std::uint8_t>(std::min(least, int{max_cells_}) + 1);
  }

  // Whether the part that holds a cell is a hole; part_ then has its cells. Only some cells of a
  // part that is none are looked at.
  bool IsHole(std::size_t seed) {
    part_ = {seed};
    states_[seed] = kOfHole;
    for (std::size_t i = 0; i < part_.size(); ++i) {
      if (Grow(part_[i])) continue;
      for (const std::size_t cell : part_) states_[cell] = kOfNoHole;
      return false;
    }
    return true;
  }

  // Adds the neighbours of a cell to the part; false when it is no hole.
  bool Grow(std::size_t cell) {
    const int column = static_cast<int>(cell % static_cast<std::size_t>(grid_.width));
    const int row = static_cast<int>(cell / static_cast<std::size_t>(grid_.width));
    for (int y = row - 1; y <= row + 1; ++y) {
      for (int x = column - 1; x <= column + 1; ++x) {
        if (!grid_.Contains({x, y}) || grid_.At({x, y}) == kOccupiedCell) return false;
        const std::size_t other = grid_.Index(x, y);
        if (grid_.cells[other] != kUnknownCell || states_[other] == kOfHole) continue;
        if (states_[other] > max_cells_) return false;
        states_[other] = kOfHole;
        part_.push_back(other);
      }
    }
    return true;
  }

  const OccupancyGrid& grid_;
  std::uint8_t max_cells_;
  // The side of an unknown cell's square, until it is looked at.
  UninitializedVector<std::uint8_t> states_;
  std::vector<std::size_t> part_;
};

}  // namespace

std::vector<std::size_t> FindUnknownHoles(const OccupancyGrid& grid, double max_width_m) {
  constexpr double kWidestHole_cells = 250;
  const double max_cells = std::floor(max_width_m / grid.resolution_m + kRounding);
  if (max_cells < 1) return {};
  return UnknownParts(grid, static_cast<std::uint8_t>(std::min(max_cells, kWidestHole_cells)))
      .Holes();
}

OccupancyGrid WithCellsFree(OccupancyGrid grid, const std::vector<std::size_t>& cells) {
  for (const std::size_t cell : cells) grid.cells[cell] = kFreeCell;
  return grid;
}

OccupancyGrid WithHolesFree(OccupancyGrid grid, double max_width_m) {
  const auto holes = FindUnknownHoles(grid, max_width_m);
  return WithCellsFree(std::move(grid), holes);
}

}  // namespace nightmap
