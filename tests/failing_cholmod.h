// SPDX-License-Identifier: Apache-2.0
// CHOLMOD without memory: while one of these lives, it gets no block larger than `max_bytes`.
#pragma once

#include <SuiteSparse_config.h>

#include <cstddef>
#include <cstdlib>

namespace nightmap {

class FailingCholmod {
 public:
  explicit FailingCholmod(std::size_t max_bytes) {
    max_bytes_ = max_bytes;
    SuiteSparse_config.malloc_func = [](std::size_t size) {
      return size > max_bytes_ ? nullptr : std::malloc(size);
    };
    SuiteSparse_config.calloc_func = [](std::size_t count, std::size_t size) {
      return count * size > max_bytes_ ? nullptr : std::calloc(count, size);
    };
  }
  ~FailingCholmod() {
    SuiteSparse_config.malloc_func = std::malloc;
    SuiteSparse_config.calloc_func = std::calloc;
  }
  FailingCholmod(const FailingCholmod&) = delete;
  FailingCholmod& operator=(const FailingCholmod&) = delete;

 private:
  static inline std::size_t max_bytes_ = 0;
};

}  // namespace nightmap
