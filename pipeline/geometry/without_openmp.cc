// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/without_openmp.h"

#include <dlfcn.h>

namespace nightmap {

WithoutOpenMp::WithoutOpenMp() {
  const auto get = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"));
  set_ = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
  if (get) num_levels_ = get();
  if (set_) set_(0);
}

WithoutOpenMp::~WithoutOpenMp() {
  if (set_) set_(num_levels_);
}

}  // namespace nightmap
