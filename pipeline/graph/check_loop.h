// SPDX-License-Identifier: Apache-2.0
// Refuses loops of other frames.
#pragma once

#include <cstddef>

#include "pipeline/io/matches_io.h"

namespace nightmap {

// Throws InputError of the port `loops` unless the pair joins an earlier frame to a later one, both
// of the site's `num_frames`.
void CheckLoop(const FramePair& loop, std::size_t num_frames);

}  // namespace nightmap
