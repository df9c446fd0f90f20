// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/camera/vocabulary_tree.h"

namespace nightmap {
namespace {

// Word -> count, ascending by word.
std::map<int, int> CountWords(const std::vector<int>& words) {
  std::map<int, int> counts;
  for (const int word : words) ++counts[word];
  return counts;
}

bool IsBetter(const InvertedFile::Result& a, const InvertedFile::Result& b) {
  return a.score != b.score ? a.score > b.score : a.frame_idx < b.frame_idx;
}

}  // namespace

InvertedFile::InvertedFile(const std::vector<std::vector<int>>& words) : words_(words) {
  int max_word = -1;
  for (const auto& list : words_) {
    for (const int word : list) max_word = std::max(max_word, word);
  }
  postings_.resize(static_cast<std::size_t>(max_word + 1));
  for (std::size_t frame = 0; frame < words_.size(); ++frame) {
    for (const auto& [word, count] : CountWords(words_[frame])) {
      postings_[static_cast<std::size_t>(word)].emplace_back(static_cast<int>(frame),
                                                             static_cast<float>(count));
    }
  }
  idf_.resize(postings_.size(), 0.0F);
  std::vector<double> squared_norms(words_.size(), 0.0);
  for (std::size_t word = 0; word < postings_.size(); ++word) {
    if (postings_[word].empty()) continue;
    // Adds one, so that a map of one frame still scores.
    idf_[word] = static_cast<float>(std::log(static_cast<double>(words_.size() + 1) /
                                             static_cast<double>(postings_[word].size())));
    for (auto& [frame, weight] : postings_[word]) {
      weight *= idf_[word];
      squared_norms[static_cast<std::size_t>(frame)] += static_cast<double>(weight) * weight;
    }
  }
  for (auto& posting : postings_) {
    for (auto& [frame, weight] : posting) {
      weight /= static_cast<float>(std::sqrt(squared_norms[static_cast<std::size_t>(frame)]));
    }
  }
}

std::vector<InvertedFile::Result> InvertedFile::Query(const std::vector<int>& words,
                                                      int count,
                                                      int before_frame_idx) const {
  std::vector<double> scores(words_.size(), 0.0);
  double squared_norm = 0;
  for (const auto& [word, num_occurrences] : CountWords(words)) {
    if (word < 0 || word >= static_cast<int>(postings_.size())) continue;
    const double weight =
        num_occurrences * static_cast<double>(idf_[static_cast<std::size_t>(word)]);
    squared_norm += weight * weight;
    for (const auto& [frame, frame_weight] : postings_[static_cast<std::size_t>(word)]) {
      scores[static_cast<std::size_t>(frame)] += weight * static_cast<double>(frame_weight);
    }
  }
  std::vector<Result> results;
  for (std::size_t frame = 0; frame < scores.size(); ++frame) {
    if (before_frame_idx >= 0 && static_cast<int>(frame) >= before_frame_idx) break;
    if (scores[frame] <= 0) continue;
    results.push_back({static_cast<int>(frame), scores[frame] / std::sqrt(squared_norm)});
  }
  const std::size_t num_kept =
      std::min(results.size(), static_cast<std::size_t>(std::max(count, 0)));
  std::partial_sort(results.begin(),
                    results.begin() + static_cast<std::ptrdiff_t>(num_kept),
                    results.end(),
                    IsBetter);
  results.resize(num_kept);
  return results;
}

}  // namespace nightmap
