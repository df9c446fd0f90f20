// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/obstacle_distances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "pipeline/plan/distance_transform.h"

namespace nightmap {
namespace {

constexpr std::size_t kLanes = 32;  // cells of a row that are computed together, in registers
// Up to this reach the sum of two squares fits 16 bits.
constexpr std::int32_t kMaxShortReach = 181;

// Gap along one axis between squares of cells whose centres are `distance` apart.
std::int32_t Gap(std::int32_t distance) { return std::max(distance, 1) - 1; }

// Takes values, so that the compiler vectorizes it.
template <typename Value>
Value Least(Value a, Value b) {
  return a < b ? a : b;
}

// For each cell of a row, the least sum of the squared gap along x and the column's squared
// distance, over the columns up to `reach` away.
template <typename Value>
void LeastSums(const std::uint16_t* columns,
               std::size_t width,
               bool outside_blocked,
               std::size_t reach,
               std::uint32_t* squared) {
  const auto limit = static_cast<Value>(reach);
  const std::size_t rim = reach + 1;
  // The gaps, padded on both sides and in the last lanes.
  std::vector<Value> gaps(width + 2 * rim + kLanes, outside_blocked ? Value{0} : limit);
  for (std::size_t x = 0; x < width; ++x) {
    const auto gap = static_cast<Value>(std::max<std::uint16_t>(columns[x], 1) - 1);
    gaps[rim + x] = std::min(gap, limit);
  }
  // Squares of the least of three, because there is no gap along x to adjacent columns.
  const std::size_t num_squares = gaps.size() - 2;
  std::vector<Value> squares(num_squares);
  for (std::size_t i = 0; i < num_squares; ++i) {
    const Value beside = Least(gaps[i], gaps[i + 2]);
    const Value least = Least(gaps[i + 1], beside);
    squares[i] = static_cast<Value>(least * least);
  }
  for (std::size_t x = 0; x < width; x += kLanes) {
    const Value* own = squares.data() + reach + x;
    std::array<Value, kLanes> least;
    std::copy_n(own, kLanes, least.begin());
    Value most = 0;  // columns farther away than its root cannot change the result
    for (std::size_t i = 0; i < kLanes; ++i) most = least[i] > most ? least[i] : most;
    for (std::size_t gap = 1; gap < reach && gap * gap < most; ++gap) {
      const auto along_x = static_cast<Value>(gap * gap);
      for (std::size_t i = 0; i < kLanes; ++i) {
        const auto sum = static_cast<Value>(Least(*(own - gap + i), own[i + gap]) + along_x);
        least[i] = Least(least[i], sum);
      }
    }
    std::copy_n(least.begin(), std::min(kLanes, width - x), squared + x);
  }
}

}  // namespace

ObstacleDistances::ObstacleDistances(const OccupancyGrid& grid,
                                     bool unknown_is_obstacle,
                                     int num_threads)
    : width_(grid.width),
      height_(grid.height),
      resolution_m_(grid.resolution_m),
      outside_blocked_(unknown_is_obstacle) {
  const auto distances = [&](const std::vector<std::uint8_t>& blocked) {
    return ColumnDistances(blocked, width_, grid.height, outside_blocked_, num_threads);
  };
  if (unknown_is_obstacle) {
    columns_ = distances(grid.cells);  // all but free cells
    return;
  }
  std::vector<std::uint8_t> blocked(grid.cells.size());
  for (std::size_t i = 0; i < blocked.size(); ++i) blocked[i] = grid.cells[i] == kOccupiedCell;
  columns_ = distances(blocked);
}

double ObstacleDistances::Clearance_m(const Eigen::Vector2d& point, double cap_m) const {
  const Eigen::Array2i last(width_ - 1, height_ - 1);
  const Eigen::Array2d cells = point.array().floor();
  if (outside_blocked_ && ((cells < 0).any() || (cells > last.cast<double>()).any())) return 0;
  const Eigen::Vector2i own = cells.max(0).min(last.cast<double>()).cast<int>();
  const double cap = std::pow(cap_m / resolution_m_, 2);
  double squared = std::numeric_limits<double>::infinity();
  // The nearest of a column: its distance does not tell whether it is above or below.
  const auto look = [&](int x) {
    const int distance = x >= 0 && x < width_ ? Row(own.y())[x] : 0;
    if (std::pow(Gap(distance), 2) >= squared) return;
    for (const int y : {own.y() - distance, own.y() + distance}) {
      if (!IsObstacle({x, y})) continue;
      const Eigen::Array2d beside = (point.array() - Eigen::Array2d(x + 0.5, y + 0.5)).abs() - 0.5;
      squared = std::min(squared, beside.max(0).matrix().squaredNorm());
    }
  };
  look(own.x());
  for (int offset = 1; std::pow(offset - 1, 2) < std::min(squared, cap) && offset <= width_;
       ++offset) {
    look(own.x() - offset);
    look(own.x() + offset);
  }
  return std::min(cap_m, resolution_m_ * std::sqrt(squared));
}

bool ObstacleDistances::Fits(const Eigen::Vector2d& point, double radius_m) const {
  const double least_m = radius_m - kFileRounding_m;
  return least_m > 0 ? Clearance_m(point, least_m) >= least_m
                     : !IsObstacle(point.array().floor().cast<int>());
}

std::int32_t ObstacleDistances::Squared(const Eigen::Vector2i& cell, std::int32_t cap) const {
  const std::uint16_t* row = Row(cell.y());
  const auto square = [](std::int64_t gap) { return gap * gap; };
  const auto column = [&](int x) -> std::int64_t {
    if (x >= 0 && x < width_) return square(Gap(row[x]));
    return outside_blocked_ ? 0 : std::numeric_limits<std::int32_t>::max();
  };
  std::int64_t least = std::min<std::int64_t>(column(cell.x()), cap);
  for (int offset = 1; square(offset - 1) < least && offset <= width_; ++offset) {
    const std::int64_t beside = std::min(column(cell.x() - offset), column(cell.x() + offset));
    least = std::min(least, square(offset - 1) + beside);
  }
  return static_cast<std::int32_t>(least);
}

void ObstacleDistances::SquaredOfRow(int y,
                                     std::int32_t cap,
                                     std::vector<std::uint32_t>& squared) const {
  const auto width = static_cast<std::size_t>(width_);
  const auto reach = static_cast<std::int32_t>(std::ceil(std::sqrt(static_cast<double>(cap))));
  squared.resize(width);
  const auto least_sums =
      reach <= kMaxShortReach ? LeastSums<std::uint16_t> : LeastSums<std::uint32_t>;
  least_sums(Row(y), width, outside_blocked_, static_cast<std::size_t>(reach), squared.data());
}

}  // namespace nightmap
