// SPDX-License-Identifier: Apache-2.0
// A zero-initialized array that spends time and memory only on the parts that are touched.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace nightmap {

// A search touches only a part of a large grid; std::vector would first write zeros over all of it.
template <typename Value>
class CellArray {
  static_assert(std::is_trivial_v<Value>);

 public:
  explicit CellArray(std::size_t size)
      : values_(static_cast<Value*>(std::calloc(size, sizeof(Value)))) {
    if (!values_) throw std::bad_alloc();
  }
  Value& operator[](std::size_t index) { return values_.get()[index]; }
  const Value& operator[](std::size_t index) const { return values_.get()[index]; }

 private:
  struct Free {
    void operator()(Value* values) const { std::free(values); }
  };
  std::unique_ptr<Value, Free> values_;
};

// Numbers the cells of a grid by squares of 16 x 16 cells, so that a search within a narrow part of
// the grid touches few pages of memory.
class SquareOrder {
 public:
  SquareOrder(int width, int height)
      : row_bits_(static_cast<int>(std::bit_width(static_cast<unsigned>(width) >> kSideBits))),
        size_(static_cast<std::size_t>((height >> kSideBits) + 1) << (row_bits_ + 2 * kSideBits)) {}

  std::size_t Size() const { return size_; }
  std::size_t Index(const Eigen::Vector2i& cell) const {
    const auto x = static_cast<std::size_t>(cell.x());
    const auto y = static_cast<std::size_t>(cell.y());
    const std::size_t square = ((y >> kSideBits) << row_bits_) | (x >> kSideBits);
    return (((square << kSideBits) | (y & kInside)) << kSideBits) | (x & kInside);
  }
  Eigen::Vector2i Cell(std::size_t index) const {
    const std::size_t inside_x = index & kInside;
    const std::size_t inside_y = (index >> kSideBits) & kInside;
    const std::size_t square = index >> (2 * kSideBits);
    const std::size_t row = square >> row_bits_;
    const std::size_t column = square & ((std::size_t{1} << row_bits_) - 1);
    return {static_cast<int>((column << kSideBits) | inside_x),
            static_cast<int>((row << kSideBits) | inside_y)};
  }

 private:
  static constexpr int kSideBits = 4;
  static constexpr std::size_t kInside = (1 << kSideBits) - 1;

  int row_bits_;  // the number of squares per row is rounded up to a power of two
  std::size_t size_;
};

}  // namespace nightmap
