// SPDX-License-Identifier: Apache-2.0
// Pattern of a sparse symmetric system of poses, as many unknowns each, and the order in which they
// are eliminated: approximate minimum degree (Amestoy, Davis, Duff, SIAM J. Matrix Anal. Appl.
// 1996).
#pragma once

#include <Eigen/SparseCore>
#include <vector>

namespace nightmap {

struct BlockPattern {
  // Rank of a pose in the order of elimination; -1: not free.
  std::vector<int> rank;
  // By pose: those of its neighbours that come later, by rank.
  std::vector<std::vector<int>> later;
  // Lower triangle, all zero: the poses by rank, then the unknowns on the right, which all poses
  // share. A column of a pose holds the rows of its own block, then those of `later`; blocks on
  // the diagonal are stored whole.
  Eigen::SparseMatrix<double> lower;
};

// `neighbours`: of each free pose the other free poses with which it shares an entry, each once, in
// both directions. `block_size`: unknowns of each. Deterministic. Throws DataError when the system
// is too large.
BlockPattern MakeBlockPattern(const std::vector<bool>& is_free,
                              const std::vector<std::vector<int>>& neighbours,
                              int block_size,
                              int num_right);

}  // namespace nightmap
