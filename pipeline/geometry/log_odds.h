// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace nightmap {

inline float LogOdds(double probability) {
  return static_cast<float>(std::log(probability / (1 - probability)));
}

}  // namespace nightmap
