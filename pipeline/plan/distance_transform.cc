// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/distance_transform.h"

#include <algorithm>
#include <array>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

constexpr int kMaxSum = 46340;  // of the sides, in cells: its square fits 32 bits
constexpr int kRowsPerItem = 64;
constexpr int kColumnsPerItem = 256;  // so that their data stays in the cache between both sweeps

std::size_t Offset(int row, int width) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
}

// Sweeps the columns from `first` on, row by row, so that the inner loops run along memory.
void SweepColumns(const std::vector<std::uint8_t>& blocked,
                  int width,
                  int height,
                  int first,
                  std::uint16_t border,
                  UninitializedVector<std::uint16_t>& distances) {
  const auto far = static_cast<std::uint16_t>(width + height);
  const int num_columns = std::min(kColumnsPerItem, width - first);
  std::array<std::uint16_t, kColumnsPerItem> nearest = {};  // of the previous row
  nearest.fill(border);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* cells = blocked.data() + Offset(y, width) + first;
    std::uint16_t* row = distances.data() + Offset(y, width) + first;
    for (std::size_t x = 0; x < static_cast<std::size_t>(num_columns); ++x) {
      const auto next = static_cast<std::uint16_t>(nearest[x] + 1);
      nearest[x] = cells[x] != 0 ? std::uint16_t{0} : std::min(next, far);
      row[x] = nearest[x];
    }
  }
  nearest.fill(border);
  for (int y = height - 1; y >= 0; --y) {
    std::uint16_t* row = distances.data() + Offset(y, width) + first;
    for (std::size_t x = 0; x < static_cast<std::size_t>(num_columns); ++x) {
      nearest[x] = std::min(row[x], static_cast<std::uint16_t>(nearest[x] + 1));
      row[x] = nearest[x];
    }
  }
}

// Lower envelope of the parabolas (x - i)^2 + column[i]^2, evaluated at every x of one row.
class RowEnvelope {
 public:
  explicit RowEnvelope(int width)
      : width_(width),
        columns_(static_cast<std::size_t>(width)),
        apexes_(static_cast<std::size_t>(width)),
        starts_(static_cast<std::size_t>(width)) {}

  // Turns the column distances of a row into its squared distances.
  void Apply(const std::uint16_t* columns, std::int32_t* row, bool outside_blocked) {
    std::copy_n(columns, width_, columns_.begin());
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
  std::vector<int> starts_;  // x from which each is the lowest
};

}  // namespace

UninitializedVector<std::uint16_t> ColumnDistances(const std::vector<std::uint8_t>& blocked,
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
  const auto border = static_cast<std::uint16_t>(outside_blocked ? 0 : width + height);
  UninitializedVector<std::uint16_t> distances(blocked.size());
  const int num_items = (width + kColumnsPerItem - 1) / kColumnsPerItem;
  ParallelFor(static_cast<std::size_t>(num_items), num_threads, [&](std::size_t item) {
    const int first = static_cast<int>(item) * kColumnsPerItem;
    SweepColumns(blocked, width, height, first, border, distances);
  });
  return distances;
}

std::vector<std::int32_t> SquaredDistances(const std::vector<std::uint8_t>& blocked,
                                           int width,
                                           int height,
                                           bool outside_blocked,
                                           int num_threads) {
  const auto columns = ColumnDistances(blocked, width, height, outside_blocked, num_threads);
  std::vector<std::int32_t> distances(blocked.size());
  const int num_items = (height + kRowsPerItem - 1) / kRowsPerItem;
  ParallelFor(static_cast<std::size_t>(num_items), num_threads, [&](std::size_t item) {
    RowEnvelope envelope(width);
    const int first = static_cast<int>(item) * kRowsPerItem;
    for (int y = first; y < std::min(first + kRowsPerItem, height); ++y) {
      const std::size_t offset = Offset(y, width);
      envelope.Apply(columns.data() + offset, distances.data() + offset, outside_blocked);
    }
  });
  return distances;
}

}  // namespace nightmap
