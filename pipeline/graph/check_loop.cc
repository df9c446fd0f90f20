// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/check_loop.h"

#include "pipeline/base/input_error.h"

namespace nightmap {

void CheckLoop(const FramePair& loop, std::size_t num_frames) {
  if (loop.frame_a >= 0 && loop.frame_a < loop.frame_b &&
      static_cast<std::size_t>(loop.frame_b) < num_frames) {
    return;
  }
  throw InputError(
      {{"loops"}}, "loop {}-{} is not between frames of this site", loop.frame_a, loop.frame_b);
}

}  // namespace nightmap
