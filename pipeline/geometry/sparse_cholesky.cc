// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/sparse_cholesky.h"

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/geometry/without_openmp.h"

namespace nightmap {
void SparseCholesky::Analyze(const Eigen::SparseMatrix<double>& lower) {
  cholesky_.cholmod().print = 0;  // CheckFits reports failures
  cholesky_.cholmod().nmethods = 1;
  cholesky_.cholmod().method[0].ordering = CHOLMOD_NATURAL;
  cholesky_.cholmod().postorder = 0;  // another order would make it copy the matrix, twice
  cholesky_.analyzePattern(lower);
  CheckFits(lower.rows());
}

std::optional<Eigen::VectorXd> SparseCholesky::Solve(const Eigen::SparseMatrix<double>& lower,
                                                     const Eigen::VectorXd& right_side) {
  const WithoutOpenMp without_openmp;
  cholesky_.factorize(lower);
  CheckFits(lower.rows());
  if (cholesky_.info() != Eigen::Success) return {};
  Eigen::VectorXd solution = cholesky_.solve(right_side);
  CheckFits(lower.rows());
  return solution;
}

// Distinguishes CHOLMOD's failures, all of which Eigen reports as not positive definite or as
// success.
void SparseCholesky::CheckFits(Eigen::Index size) {
  const int status = cholesky_.cholmod().status;
  if (status >= CHOLMOD_OK) return;
  const char* reason = status == CHOLMOD_OUT_OF_MEMORY ? "does not fit into memory"
                       : status == CHOLMOD_TOO_LARGE   ? "is too large for 32-bit indices"
                                                       : "cannot be made";
  throw DataError(
      "the factor of a system of {} unknowns {} (CHOLMOD {}); {}", size, reason, status, remedy_);
}

int SparseIndex(std::size_t count) {
  if (count <= static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    return static_cast<int>(count);
  }
  throw DataError(
      "a system of {} entries is too large for 32-bit indices; map a part of the recording", count);
}

}  // namespace nightmap
