// SPDX-License-Identifier: Apache-2.0
// Keeps CHOLMOD from opening parallel regions.
#pragma once

namespace nightmap {

// While it lives, OpenMP, if CHOLMOD is built with it, opens no parallel regions: CHOLMOD asks for
// four threads for each of many blocks of a few rows, and waiting for them takes half of the time.
class WithoutOpenMp {
 public:
  WithoutOpenMp();
  ~WithoutOpenMp();
  WithoutOpenMp(const WithoutOpenMp&) = delete;
  WithoutOpenMp& operator=(const WithoutOpenMp&) = delete;

 private:
  int num_levels_ = 1;
  void (*set_)(int) = nullptr;
};

}  // namespace nightmap
