// SPDX-License-Identifier: Apache-2.0
// census: counts what a recording gave the map. add_wing_test.py adds this wing to a copy of the
// tree; it is the smallest that a wing can be.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "pipeline/base/options.h"

namespace nightmap {

struct CensusOptions {
  OPTION(int, min_keyframes, 1, {1, 1'000'000}, "keyframes below which the stage fails");
  REGISTER_OPTIONS();
};

// num_frames and num_keyframes. Throws ThresholdError when there are fewer than min_keyframes.
nlohmann::json RunCensus(const CensusOptions& options,
                         std::size_t num_frames,
                         std::size_t num_keyframes);

}  // namespace nightmap
