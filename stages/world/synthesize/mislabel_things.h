// SPDX-License-Identifier: Apache-2.0
// Wrong labels, as a network gives them: a picture shows a chair, and its labels say that it is a
// sofa.
#pragma once

#include <cstdint>

#include "pipeline/world/render.h"

namespace nightmap {

// Gives each thing (true_things.h) in the picture another of kThingLabels with probability
// `mislabelled_ratio`, all its pixels the same one, each other one as probably. The fate of a thing
// depends on itself and `noise_seed` alone, so give each picture its own seed.
void MislabelThings(const Scene& scene,
                    double mislabelled_ratio,
                    std::uint64_t noise_seed,
                    RenderedFrame& frame);

}  // namespace nightmap
