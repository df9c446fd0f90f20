// SPDX-License-Identifier: Apache-2.0
// Where the blocks of a row of a sparse block matrix are.
#pragma once

#include <cstddef>
#include <vector>

namespace nightmap {

// Slot of each pose among the blocks of a row; -1: none. A thread keeps its table, because most of
// a large one stays as it is.
class RowSlots {
 public:
  RowSlots(std::size_t num_poses, std::size_t pose, const std::vector<int>& later)
      : pose_(pose), later_(later) {
    if (table_.size() != num_poses) table_.assign(num_poses, -1);
    table_[pose] = 0;
    for (std::size_t i = 0; i < later.size(); ++i) {
      table_[static_cast<std::size_t>(later[i])] = static_cast<int>(i) + 1;
    }
  }
  ~RowSlots() {
    table_[pose_] = -1;
    for (const int other : later_) table_[static_cast<std::size_t>(other)] = -1;
  }
  RowSlots(const RowSlots&) = delete;
  RowSlots& operator=(const RowSlots&) = delete;

  int Of(std::size_t pose) const { return table_[pose]; }

 private:
  static std::vector<int>& TableOfThread() {
    static thread_local std::vector<int> table;
    return table;
  }

  std::vector<int>& table_ = TableOfThread();
  std::size_t pose_;
  const std::vector<int>& later_;
};

}  // namespace nightmap
