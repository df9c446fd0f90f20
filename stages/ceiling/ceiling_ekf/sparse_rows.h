// SPDX-License-Identifier: Apache-2.0
// Builds a sparse matrix of a few small blocks.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

namespace nightmap {

// Blocks that overlap add up.
class SparseRowsBuilder {
 public:
  SparseRowsBuilder(Eigen::Index rows, Eigen::Index cols) : rows_(rows), cols_(cols) {}

  template <typename Derived>
  void Add(Eigen::Index row, Eigen::Index col, const Eigen::MatrixBase<Derived>& block) {
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
      for (Eigen::Index j = 0; j < block.cols(); ++j) Put(row + i, col + j, block(i, j));
    }
  }
  // Ones from (row, col) down the diagonal.
  void Identity(Eigen::Index row, Eigen::Index count, Eigen::Index col) {
    for (Eigen::Index i = 0; i < count; ++i) Put(row + i, col + i, 1);
  }
  void Identity(Eigen::Index first, Eigen::Index count) { Identity(first, count, first); }

  Eigen::SparseMatrix<double, Eigen::RowMajor> Build() const {
    Eigen::SparseMatrix<double, Eigen::RowMajor> matrix(rows_, cols_);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    return matrix;
  }

 private:
  void Put(Eigen::Index row, Eigen::Index col, double value) {
    entries_.emplace_back(static_cast<int>(row), static_cast<int>(col), value);
  }

  Eigen::Index rows_, cols_;
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace nightmap
