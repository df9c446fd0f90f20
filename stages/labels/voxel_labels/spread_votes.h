// SPDX-License-Identifier: Apache-2.0
// Lets the keyframes that saw a part of a thing speak for all of it.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/base/options.h"

namespace nightmap {

struct SpreadOptions {
  OPTION(double, spread_weight, 64, {0.0, 1e6},
         "how much neighbouring voxels that look alike hold together, in keyframes");
  OPTION(int, spread_iterations, 20, {0, 1000},
         "steps over which votes spread, a voxel each; 0: each voxel has its own alone");
  REGISTER_OPTIONS();
};

// Votes of the keyframes for voxels: voxel i has the weights [i * num_classes, (i + 1) *
// num_classes), all 0 where nobody saw it.
struct VoteTable {
  std::vector<std::uint64_t> codes;  // MortonCode of each voxel, ascending
  std::size_t num_classes = 0;
  std::vector<float> weights;
};

// Replaces the shares p of each voxel's votes v of sum n by those that minimize
//   sum_i n_i |p_i - v_i / n_i|^2 + spread_weight * sum_ij b_ij |p_i - p_j|^2
// over voxels i and their 18 neighbours j, by spread_iterations steps of Jacobi's method. The bond
// b_ij is the fourth power of the cosine of v_i and v_j: a picture mistakes a thing as a whole, so
// the votes on two of its voxels have the same classes, right or wrong, and those beyond its border
// others. A voxel stays as it is where all votes on it and its neighbours are for one class. The
// sum of a voxel's weights stays; one that nobody saw gets a small one if a neighbour has any. Same
// result at any number of threads.
void SpreadVotes(const SpreadOptions& options, int num_threads, VoteTable* votes);

}  // namespace nightmap
