// SPDX-License-Identifier: Apache-2.0
// Indices sorted into groups.
#pragma once

#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace nightmap {

// Indices by group; ascending in each group.
class IndexGroups {
 public:
  IndexGroups() = default;
  IndexGroups(const std::vector<int>& group_of_index, std::size_t num_groups)
      : begins_(num_groups + 1, 0), members_(group_of_index.size()) {
    for (const int group : group_of_index) ++begins_[static_cast<std::size_t>(group) + 1];
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    std::vector<std::size_t> next = begins_;
    for (std::size_t i = 0; i < group_of_index.size(); ++i) {
      members_[next[static_cast<std::size_t>(group_of_index[i])]++] = static_cast<int>(i);
    }
  }

  std::span<const int> Of(std::size_t group) const {
    return {members_.data() + begins_[group], members_.data() + begins_[group + 1]};
  }

 private:
  std::vector<std::size_t> begins_;
  std::vector<int> members_;
};

}  // namespace nightmap
