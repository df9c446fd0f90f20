// SPDX-License-Identifier: Apache-2.0
// An array of zeros of which only what is touched takes time and memory.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace nightmap {

// A search touches a part of a large grid; std::vector would write zeros over all of it first.
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

}  // namespace nightmap
