// SPDX-License-Identifier: Apache-2.0
#include "stages/census/census/census.h"

#include "pipeline/base/error.h"

namespace nightmap {

nlohmann::json RunCensus(const CensusOptions& options,
                         std::size_t num_frames,
                         std::size_t num_keyframes) {
  if (num_keyframes < static_cast<std::size_t>(options.min_keyframes)) {
    throw ThresholdError(
        "{} keyframes, fewer than min_keyframes = {}", num_keyframes, options.min_keyframes);
  }
  return {{"num_frames", num_frames}, {"num_keyframes", num_keyframes}};
}

}  // namespace nightmap
