// SPDX-License-Identifier: Apache-2.0
// Cholesky factorization of a sparse matrix with a fixed pattern (CHOLMOD, supernodal). It
// distinguishes a matrix that has no factor from a factor that does not fit into memory.
#pragma once

#include <Eigen/CholmodSupport>
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

namespace nightmap {

class SparseCholesky {
 public:
  // `remedy` is told where a factor does not fit.
  explicit SparseCholesky(std::string remedy) : remedy_(std::move(remedy)) {}

  // Takes the pattern of a lower triangle; eliminates rows and columns in their order,
  // which is fast where it is a postorder of the elimination tree, as approximate minimum degree
  // makes it. Throws
  // DataError when the factor fits neither the memory nor 32-bit indices.
  void Analyze(const Eigen::SparseMatrix<double>& lower);

  // Solves A x = b for a matrix A of that pattern, given by its lower triangle. Returns nothing
  // when A is not positive definite. Throws DataError when the factor does not fit. Deterministic.
  std::optional<Eigen::VectorXd> Solve(const Eigen::SparseMatrix<double>& lower,
                                       const Eigen::VectorXd& right_side);

 private:
  void CheckFits(Eigen::Index size);

  std::string remedy_;
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower> cholesky_;
};

// `count` as the factorization's 32-bit index. Throws DataError when it is too large.
int SparseIndex(std::size_t count);

}  // namespace nightmap
