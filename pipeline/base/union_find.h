// SPDX-License-Identifier: Apache-2.0
// Disjoint sets with path halving; the representative of a set is its smallest element.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace nightmap {

class UnionFind {
 public:
  explicit UnionFind(std::size_t size = 0) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  std::size_t Size() const { return parent_.size(); }
  // One more element, a set of its own; returns it.
  std::size_t Add() {
    parent_.push_back(parent_.size());
    return parent_.size() - 1;
  }

  std::size_t Find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::size_t a, std::size_t b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace nightmap
