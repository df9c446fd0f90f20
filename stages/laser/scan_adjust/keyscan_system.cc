// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/keyscan_system.h"

#include <algorithm>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr double kFixed = 1e12;  // holds the first keyscan

Eigen::Index FirstRow(std::size_t keyscan) { return 3 * static_cast<Eigen::Index>(keyscan); }

}  // namespace

KeyscanSystem::KeyscanSystem(std::size_t num_keyscans,
                             std::vector<std::pair<std::size_t, std::size_t>> pairs)
    : lower_(FirstRow(num_keyscans), FirstRow(num_keyscans)),
      gradient_(Eigen::VectorXd::Zero(FirstRow(num_keyscans))) {
  for (auto& [a, b] : pairs) {
    if (a > b) std::swap(a, b);
  }
  for (std::size_t i = 0; i < num_keyscans; ++i) pairs.emplace_back(i, i);
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  lower_.reserve(9 * static_cast<Eigen::Index>(pairs.size()));
  for (auto begin = pairs.begin(); begin != pairs.end();) {
    const auto end = std::find_if(
        begin, pairs.end(), [&](const auto& pair) { return pair.first != begin->first; });
    for (Eigen::Index column = FirstRow(begin->first); column < FirstRow(begin->first) + 3;
         ++column) {
      lower_.startVec(column);
      for (auto block = begin; block != end; ++block) {
        for (Eigen::Index row = FirstRow(block->second); row < FirstRow(block->second) + 3; ++row) {
          if (row >= column) lower_.insertBack(row, column) = 0;
        }
      }
    }
    begin = end;
  }
  lower_.finalize();
  Clear();
}

void KeyscanSystem::Clear() {
  lower_.coeffs().setZero();
  gradient_.setZero();
  for (Eigen::Index i = 0; i < std::min<Eigen::Index>(3, lower_.cols()); ++i) At(i, i) = kFixed;
}

double& KeyscanSystem::At(Eigen::Index row, Eigen::Index column) {
  const int* const rows = lower_.innerIndexPtr();
  const int* const found = std::lower_bound(rows + lower_.outerIndexPtr()[column],
                                            rows + lower_.outerIndexPtr()[column + 1],
                                            static_cast<int>(row));
  return lower_.valuePtr()[found - rows];
}

void KeyscanSystem::Add(std::size_t a,
                        std::size_t b,
                        const Matrix6& hessian,
                        const Vector6& gradient) {
  const Eigen::Index first[] = {FirstRow(a), FirstRow(b)};
  for (int j = 0; j < 6; ++j) {
    const Eigen::Index column = first[j / 3] + j % 3;
    gradient_[column] += gradient[j];
    for (const int block : {0, 1}) {
      if (first[block] < first[j / 3]) continue;
      // The rows of a block follow each other.
      const int from = block == j / 3 ? j % 3 : 0;
      double* const values = &At(first[block] + from, column);
      for (int i = from; i < 3; ++i) values[i - from] += hessian(3 * block + i, j);
    }
  }
}

Eigen::VectorXd KeyscanSystem::Step() {
  if (!is_analyzed_) solver_.analyzePattern(lower_);
  is_analyzed_ = true;
  solver_.factorize(lower_);
  Eigen::VectorXd step = -solver_.solve(gradient_);
  if (solver_.info() != Eigen::Success || !step.allFinite()) {
    throw DataError("the equations of {} keyscans have no solution; raise scan_adjust.sigma_m",
                    gradient_.size() / 3);
  }
  return step;
}

}  // namespace nightmap
