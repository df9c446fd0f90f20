// SPDX-License-Identifier: Apache-2.0
// The pattern of bundle adjustment's reduced system: which poses share points, and in which order
// they are eliminated.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"
#include "pipeline/geometry/index_groups.h"

namespace nightmap {

struct SchurPattern {
  // Rank of a pose in the order of elimination; -1: fixed or without any point.
  std::vector<int> rank;
  // By pose: the later-ranked poses with which it shares points, by rank.
  std::vector<std::vector<int>> later;
  // Lower triangle, all zero: the poses by rank, then the calibrations. Blocks on the diagonal are
  // stored whole.
  Eigen::SparseMatrix<double> reduced;
};

// Takes which pose sees which point, as observations by pose and by point. Throws DataError when
// the system is too large. The same at any number of threads.
SchurPattern MakeSchurPattern(const BundleProblem& problem,
                              const IndexGroups& of_pose,
                              const IndexGroups& of_point,
                              int num_calibrations,
                              int num_threads);

}  // namespace nightmap
