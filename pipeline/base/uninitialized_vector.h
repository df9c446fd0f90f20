// SPDX-License-Identifier: Apache-2.0
// A vector for large arrays of numbers that are written in full, in parallel, right after creation.
#pragma once

#include <memory>
#include <new>
#include <vector>

namespace nightmap {

// Skips the initialization: std::vector would zero all values on one thread whenever it is made or
// grows.
template <typename Value>
struct UninitializedAllocator : std::allocator<Value> {
  template <typename Other>
  void construct(Other* at) {  // NOLINT(readability-identifier-naming): std::allocator_traits' name
    ::new (static_cast<void*>(at)) Other;
  }
};

template <typename Value>
using UninitializedVector = std::vector<Value, UninitializedAllocator<Value>>;

}  // namespace nightmap
