// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/distance_transform.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

constexpr int kMaxSum = 46340;  // of the sides, cells: its square fits 32 bits
constexpr int kRowsPerItem = 64;

std::size_t Offset(int row, int width) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
}

// Distance to the nearest blocked cell in the same column, `far` where there is none. Row by row,
// so that the inner loop runs along memory.
std::vector<std::int32_t> ColumnDistances(const std::vector<std::uint8_t>& blocked,
                                          int width,
                                          int height,
                                          bool outside_blocked,
                                          std::int32_t far) {
  std::vector<std::int32_t> distances(blocked.size());
  const std::vector<std::int32_t> border(static_cast<std::size_t>(width),
                                         outside_blocked ? 0 : far);
  const std::int32_t* previous = border.data();
  for (int y = 0; y < height; ++y) {
    std::int32_t* row = distances.data() + Offset(y, width);
    const std::uint8_t* cells = blocked.data() + Offset(y, width);
    for (int x = 0; x < width; ++x) row[x] = cells[x] ? 0 : std::min(previous[x] + 1, far);
    previous = row;
  }
  previous = border.data();
  for (int y = height - 1; y >= 0; --y) {
    std::int32_t* row = distances.data() + Offset(y, width);
    for (int x = 0; x < width; ++x) row[x] = std::min(row[x], previous[x] + 1);
    previous = row;
  }
  return distances;
}

// Lower envelope of the parabolas (x - i)^2 + column[i]^2, evaluated at every x of one row.
class RowEnvelope {
 public:
  explicit RowEnvelope(int width)
      : width_(width),
        columns_(static_cast<std::size_t>(width)),
        apexes_(static_cast<std::size_t>(width)),
        starts_(static_cast<std::size_t>(width)) {}

  // Replaces the column distances of a row by its squared distances.
  void Apply(std::int32_t* row, bool outside_blocked) {
    for (int x = 0; x < width_; ++x) columns_[static_cast<std::size_t>(x)] = row[x];
    Build();
    for (int x = width_ - 1; x >= 0; --x) {
      const std::int32_t border = std::min(x + 1, width_ - x);
      row[x] = Value(apexes_[last_], x);
      if (outside_blocked) row[x] = std::min(row[x], border * border);
      if (x == starts_[last_] && last_ > 0) --last_;
    }
  }

 private:
  std::int32_t Square(int i) const {
    const std::int32_t column = columns_[static_cast<std::size_t>(i)];
    return column * column;
  }
  std::int32_t Value(int apex, int x) const { return (x - apex) * (x - apex) + Square(apex); }

  // First x from which the parabola at `right` is below the one at `left`.
  int Crossing(int left, int right) const {
    const std::int64_t numerator =
        std::int64_t{right} * right - std::int64_t{left} * left + Square(right) - Square(left);
    const std::int64_t denominator = 2 * (std::int64_t{right} - left);
    const std::int64_t floor =
        numerator >= 0 ? numerator / denominator : -((-numerator + denominator - 1) / denominator);
    return static_cast<int>(std::clamp<std::int64_t>(floor + 1, 0, width_));
  }

  void Build() {
    last_ = 0;
    apexes_[0] = 0;
    starts_[0] = 0;
    for (int x = 1; x < width_; ++x) {
      while (last_ > 0 && Value(apexes_[last_], starts_[last_]) > Value(x, starts_[last_])) --last_;
      if (last_ == 0 && Value(apexes_[0], 0) > Value(x, 0)) {
        apexes_[0] = x;
        continue;
      }
      const int start = Crossing(apexes_[last_], x);
      if (start >= width_) continue;
      ++last_;
      apexes_[last_] = x;
      starts_[last_] = start;
    }
  }

  int width_;
  std::size_t last_ = 0;
  std::vector<std::int32_t> columns_;
  std::vector<int> apexes_;  // x of the parabolas on the envelope
  std::vector<int> starts_;  // where each takes over
};

}  // namespace

std::vector<std::int32_t> SquaredDistances(const std::vector<std::uint8_t>& blocked,
                                           int width,
                                           int height,
                                           bool outside_blocked,
                                           int num_threads) {
  if (width + height > kMaxSum) {
    throw DataError(
        "the grid has {} x {} cells, too many for a distance transform: use a coarser resolution",
        width,
        height);
  }
  std::vector<std::int32_t> distances =
      ColumnDistances(blocked, width, height, outside_blocked, width + height);
  const int num_items = (height + kRowsPerItem - 1) / kRowsPerItem;
  ParallelFor(static_cast<std::size_t>(num_items), num_threads, [&](std::size_t item) {
    RowEnvelope envelope(width);
    const int first = static_cast<int>(item) * kRowsPerItem;
    for (int y = first; y < std::min(first + kRowsPerItem, height); ++y) {
      envelope.Apply(distances.data() + Offset(y, width), outside_blocked);
    }
  });
  return distances;
}

}  // namespace nightmap
