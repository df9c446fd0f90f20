// SPDX-License-Identifier: Apache-2.0
// Keeps CHOLMOD from opening parallel regions.
#pragma once

#include <dlfcn.h>

namespace nightmap {

// While it lives, OpenMP, if CHOLMOD is built with it, opens no parallel regions: CHOLMOD asks for
// four threads for each of many blocks of a few rows, and waiting for them takes half of the time.
class WithoutOpenMp {
 public:
  WithoutOpenMp() {
    const auto get = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"));
    set_ = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
    if (get) num_levels_ = get();
    if (set_) set_(0);
  }
  ~WithoutOpenMp() {
    if (set_) set_(num_levels_);
  }
  WithoutOpenMp(const WithoutOpenMp&) = delete;
  WithoutOpenMp& operator=(const WithoutOpenMp&) = delete;

 private:
  int num_levels_ = 1;
  void (*set_)(int) = nullptr;
};

}  // namespace nightmap
