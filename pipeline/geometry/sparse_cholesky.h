// SPDX-License-Identifier: Apache-2.0
// Cholesky factorization of a sparse matrix whose pattern stays (CHOLMOD, supernodal), which tells
// a matrix that has no factor from a factor that does not fit.
#pragma once

#include <Eigen/CholmodSupport>
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <optional>

namespace nightmap {

class SparseCholesky {
 public:
  // Takes the pattern of a lower triangle; rows and columns are eliminated in their order. Throws
  // DataError when the factor fits neither the memory nor 32 bits of an index.
  void Analyze(const Eigen::SparseMatrix<double>& lower);

  // The x of A x = b for a matrix of that pattern, given by its lower triangle; nothing when it is
  // not positive definite. Throws DataError when the factor does not fit. Deterministic.
  std::optional<Eigen::VectorXd> Solve(const Eigen::SparseMatrix<double>& lower,
                                       const Eigen::VectorXd& right_side);

 private:
  void CheckFits(Eigen::Index size);

  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower> cholesky_;
};

// `count` as the 32-bit index the factorization takes. Throws DataError when it is too large.
int SparseIndex(std::size_t count);

}  // namespace nightmap
