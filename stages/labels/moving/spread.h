// SPDX-License-Identifier: Apache-2.0
// Evidence of single pixels, spread over what hangs together.
#pragma once

#include "stages/labels/moving/evidence.h"

namespace nightmap {

struct SpreadOptions {
  double stays_weight = 0.8;     // of evidence for staying, against one for having gone
  double prior = 0.1;            // of each pixel: that it stays
  double max_depth_step = 0.03;  // relative; a larger one is an edge between two things
  int num_rounds = 40;
};

// How strongly two neighbours belong together: 1 on one surface, 0 across an edge. Across holes,
// whose surface is not known, weakly.
float Bond(float depth_a_m, float depth_b_m, double max_step);

// Spreads the evidence over what hangs together in depth, since the inside of a large thing hides
// itself and only its edge is seen to leave. Positive where more speaks for moving: -1 .. 1. The
// solution of a screened Poisson equation by Jacobi steps, whose weights vanish across depth edges.
// `decided` is 1 where a region moves and -1 where it stays: there this stands for the evidence,
// and what labels missed of a thing follows the rest of it. Empty: nothing is decided.
Image<float> SpreadEvidence(const SpreadOptions& options,
                            const Evidence& evidence,
                            const DepthImage& depth,
                            const Image<float>& decided);

}  // namespace nightmap
