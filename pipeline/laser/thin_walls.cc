// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/thin_walls.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace nightmap {
namespace {

constexpr int kRadius_cells = 4;
// Largest ratio of the variances across and along a wall. A square corner has 0.25 or more.
constexpr double kMaxVarianceRatio = 0.2;

class WallThinner {
 public:
  WallThinner(std::span<const std::uint32_t> hits, const OccupancyGrid& grid)
      : hits_(hits), grid_(grid) {}

  // New value of an occupied cell.
  std::uint8_t Thinned(const Eigen::Vector2i& cell) const {
    const auto across = AcrossWall(cell);
    if (!across) return kOccupiedCell;
    for (const int side : {1, -1}) {
      const Eigen::Vector2i next = cell + side * *across;
      // The first of two equal ones stays.
      const bool exceeds = side > 0 ? HitsOf(next) > HitsOf(cell) : HitsOf(next) >= HitsOf(cell);
      if (!exceeds) continue;
      return ValueBeside(cell, -side * *across);
    }
    return kOccupiedCell;
  }

 private:
  bool Contains(const Eigen::Vector2i& cell) const {
    return cell.x() >= 0 && cell.y() >= 0 && cell.x() < grid_.width && cell.y() < grid_.height;
  }
  std::uint8_t ValueOf(const Eigen::Vector2i& cell) const {
    return Contains(cell) ? grid_.At(cell) : static_cast<std::uint8_t>(kUnknownCell);
  }
  // Only occupied cells are part of a wall: others have none.
  std::uint32_t HitsOf(const Eigen::Vector2i& cell) const {
    return ValueOf(cell) == kOccupiedCell ? hits_[grid_.Index(cell.x(), cell.y())] : 0;
  }

  // Value beside the wall in the direction of a step: free, or unknown. Where the hits rise
  // again, another wall begins, as the other face of a partition, whose inside was not seen.
  std::uint8_t ValueBeside(Eigen::Vector2i cell, const Eigen::Vector2i& step) const {
    while (HitsOf(cell + step) > 0 && HitsOf(cell + step) <= HitsOf(cell)) cell += step;
    return ValueOf(cell + step) == kFreeCell ? kFreeCell : kUnknownCell;
  }

  // The step to the neighbour across the wall; none: the cell is on no straight piece of wall.
  std::optional<Eigen::Vector2i> AcrossWall(const Eigen::Vector2i& cell) const {
    double sum = 0;
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    Eigen::Matrix2d second_moment = Eigen::Matrix2d::Zero();
    for (int y = -kRadius_cells; y <= kRadius_cells; ++y) {
      for (int x = -kRadius_cells; x <= kRadius_cells; ++x) {
        const Eigen::Vector2d offset(x, y);
        const double weight = std::sqrt(HitsOf(cell + Eigen::Vector2i(x, y)));
        sum += weight;
        moment += weight * offset;
        second_moment += weight * offset * offset.transpose();
      }
    }
    const Eigen::Vector2d mean = moment / sum;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(second_moment / sum -
                                                              mean * mean.transpose());
    // A single cell has no variance at all.
    if (!(axes.eigenvalues()[1] > 1) ||
        axes.eigenvalues()[0] > kMaxVarianceRatio * axes.eigenvalues()[1]) {
      return std::nullopt;
    }
    const Eigen::Vector2d normal = axes.eigenvectors().col(0);
    // The neighbour nearest to the normal: components below sin(22.5 deg) count as none.
    constexpr double kSineOfHalfStep = 0.38268343236508977;
    const auto step = [](double component) {
      return std::abs(component) < kSineOfHalfStep ? 0 : component > 0 ? 1 : -1;
    };
    Eigen::Vector2i across(step(normal.x()), step(normal.y()));
    // An axis has no sign: take the one that every cell of a wall takes.
    if (across.x() < 0 || (across.x() == 0 && across.y() < 0)) across = -across;
    return across;
  }

  std::span<const std::uint32_t> hits_;
  const OccupancyGrid& grid_;
};

}  // namespace

void ThinWalls(std::span<const std::uint32_t> hits, OccupancyGrid* grid) {
  const OccupancyGrid before = *grid;
  const WallThinner thinner(hits, before);
  for (int y = 0; y < before.height; ++y) {
    for (int x = 0; x < before.width; ++x) {
      if (before.At({x, y}) != kOccupiedCell) continue;
      grid->cells[before.Index(x, y)] = thinner.Thinned({x, y});
    }
  }
}

}  // namespace nightmap
