// SPDX-License-Identifier: Apache-2.0
// Normal equations of the poses of all keyscans: three unknowns each, x, y and heading.
#pragma once

#include <Eigen/SparseCholesky>
#include <cstddef>
#include <utility>
#include <vector>

#include "stages/laser/scan_adjust/compare_scans.h"

namespace nightmap {

// Keeps the lower triangle alone, and its pattern from one round to the next: memory is that of the
// matrix and its factor. Sums in the order of the calls of Add.
class KeyscanSystem {
 public:
  // `pairs`: those that Add is called with, in any order and as often as they come.
  KeyscanSystem(std::size_t num_keyscans, std::vector<std::pair<std::size_t, std::size_t>> pairs);

  // All equations are zero, but those that hold the first keyscan.
  void Clear();
  // Equations of keyscans a and b, which differ.
  void Add(std::size_t a, std::size_t b, const Matrix6& hessian, const Vector6& gradient);
  // The step to the minimum. Throws DataError when the equations have no solution.
  Eigen::VectorXd Step();

 private:
  double& At(Eigen::Index row, Eigen::Index column);

  Eigen::SparseMatrix<double> lower_;
  Eigen::VectorXd gradient_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
  bool is_analyzed_ = false;
};

}  // namespace nightmap
