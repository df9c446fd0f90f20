// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/word_index.h"

#include <numeric>

namespace nightmap {
namespace {

// Sorts stably by the word at a level.
std::vector<int> SortByWord(const LandmarkMap& map,
                            int level,
                            int num_words,
                            const std::vector<int>& rows) {
  std::vector<int> begins(static_cast<std::size_t>(num_words) + 1, 0);
  for (const int row : rows) ++begins[static_cast<std::size_t>(map.Word(row, level)) + 1];
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<int> sorted(rows.size());
  for (const int row : rows) {
    int& next = begins[static_cast<std::size_t>(map.Word(row, level))];
    sorted[static_cast<std::size_t>(next++)] = row;
  }
  return sorted;
}

}  // namespace

WordIndex::WordIndex(const LandmarkMap& map, const VocabularyTree& tree)
    : descriptor_size_(static_cast<std::size_t>(DescriptorSize(map.kind))),
      rows_(static_cast<std::size_t>(map.NumDescriptors())),
      ranges_(static_cast<std::size_t>(tree.NumNodes())) {
  std::iota(rows_.begin(), rows_.end(), 0);
  for (int level = map.num_word_levels; level >= 1; --level) {
    rows_ = SortByWord(map, level, tree.NumNodes(), rows_);
  }
  values_.reserve(map.descriptors.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const auto row = static_cast<std::size_t>(rows_[i]);
    const auto value =
        map.descriptors.begin() + static_cast<std::ptrdiff_t>(row * descriptor_size_);
    values_.insert(values_.end(), value, value + static_cast<std::ptrdiff_t>(descriptor_size_));
    for (int level = 1; level <= map.num_word_levels; ++level) {
      Range& range = ranges_[static_cast<std::size_t>(map.Word(rows_[i], level))];
      const int at = static_cast<int>(i);
      if (range.end < at) range.begin = at;
      range.end = at + 1;
    }
  }
}

WordIndex::Block WordIndex::Of(int word) const {
  const Range& range = ranges_[static_cast<std::size_t>(word)];
  const auto begin = static_cast<std::size_t>(range.begin);
  const auto size = static_cast<std::size_t>(range.end - range.begin);
  return {std::span(rows_).subspan(begin, size), values_.data() + begin * descriptor_size_};
}

}  // namespace nightmap
