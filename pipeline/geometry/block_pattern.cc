// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/block_pattern.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <iterator>

#include "pipeline/geometry/sparse_cholesky.h"

namespace nightmap {
namespace {

// Approximate minimum degree on poses, because the pattern inside a block does not help.
std::vector<int> RankPoses(const std::vector<bool>& is_free,
                           const std::vector<std::vector<int>>& neighbours) {
  std::vector<int> free;
  std::vector<int> position(is_free.size(), -1);
  for (std::size_t pose = 0; pose < is_free.size(); ++pose) {
    if (!is_free[pose]) continue;
    position[pose] = static_cast<int>(free.size());
    free.push_back(static_cast<int>(pose));
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (const int pose : free) {
    const auto i = static_cast<std::size_t>(pose);
    entries.emplace_back(position[i], position[i], 1);
    for (const int other : neighbours[i]) {
      entries.emplace_back(position[i], position[static_cast<std::size_t>(other)], 1);
    }
  }
  const auto num_free = static_cast<Eigen::Index>(free.size());
  Eigen::SparseMatrix<double> pattern(num_free, num_free);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  std::vector<int> rank(is_free.size(), -1);
  for (Eigen::Index k = 0; k < num_free; ++k) {
    const auto pose = static_cast<std::size_t>(free[static_cast<std::size_t>(order.indices()[k])]);
    rank[pose] = static_cast<int>(k);
  }
  return rank;
}

// Poses by rank. Fills `later`.
std::vector<std::size_t> FindLater(const std::vector<std::vector<int>>& neighbours,
                                   BlockPattern* pattern) {
  const auto rank = [&](int pose) { return pattern->rank[static_cast<std::size_t>(pose)]; };
  std::vector<std::size_t> by_rank;
  pattern->later.resize(neighbours.size());
  for (std::size_t pose = 0; pose < neighbours.size(); ++pose) {
    if (pattern->rank[pose] < 0) continue;
    by_rank.push_back(pose);
    std::vector<int>& later = pattern->later[pose];
    std::ranges::copy_if(neighbours[pose], std::back_inserter(later), [&](int other) {
      return rank(other) > pattern->rank[pose];
    });
    std::ranges::sort(later, {}, rank);
  }
  std::ranges::sort(by_rank, {}, [&](std::size_t pose) { return pattern->rank[pose]; });
  return by_rank;
}

// Columns of one block, or all on the right, have the same rows.
class ColumnWriter {
 public:
  ColumnWriter(int size, int num_entries, Eigen::SparseMatrix<double>* matrix) : matrix_(*matrix) {
    matrix_.resize(size, size);
    matrix_.resizeNonZeros(num_entries);
    std::fill_n(matrix_.valuePtr(), num_entries, 0.0);
    matrix_.outerIndexPtr()[0] = 0;
  }

  void Add(const std::vector<int>& rows, int num_columns) {
    for (int i = 0; i < num_columns; ++i) {
      std::ranges::copy(rows, matrix_.innerIndexPtr() + end_);
      end_ += static_cast<int>(rows.size());
      matrix_.outerIndexPtr()[++column_] = end_;
    }
  }

 private:
  Eigen::SparseMatrix<double>& matrix_;
  int column_ = 0;
  int end_ = 0;
};

void AppendRange(int begin, int count, std::vector<int>* rows) {
  for (int i = 0; i < count; ++i) rows->push_back(begin + i);
}

void LayOut(const std::vector<std::size_t>& by_rank,
            int block_size,
            int num_right,
            BlockPattern* pattern) {
  const auto right = static_cast<std::size_t>(num_right);
  const auto size = static_cast<std::size_t>(block_size);
  std::size_t num_entries = right * right;
  for (const std::size_t pose : by_rank) {
    num_entries += size * (size * (pattern->later[pose].size() + 1) + right);
  }
  const int num_pose_columns = SparseIndex(size * by_rank.size());
  ColumnWriter writer(num_pose_columns + num_right, SparseIndex(num_entries), &pattern->lower);
  for (const std::size_t pose : by_rank) {
    std::vector<int> rows;
    AppendRange(block_size * pattern->rank[pose], block_size, &rows);
    for (const int other : pattern->later[pose]) {
      AppendRange(block_size * pattern->rank[static_cast<std::size_t>(other)], block_size, &rows);
    }
    AppendRange(num_pose_columns, num_right, &rows);
    writer.Add(rows, block_size);
  }
  std::vector<int> rows;
  AppendRange(num_pose_columns, num_right, &rows);
  writer.Add(rows, num_right);
}

}  // namespace

BlockPattern MakeBlockPattern(const std::vector<bool>& is_free,
                              const std::vector<std::vector<int>>& neighbours,
                              int block_size,
                              int num_right) {
  BlockPattern pattern{RankPoses(is_free, neighbours), {}, {}};
  LayOut(FindLater(neighbours, &pattern), block_size, num_right, &pattern);
  return pattern;
}

}  // namespace nightmap
