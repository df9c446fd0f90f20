// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/inverted_file.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace nightmap {
namespace {

// Words and how often each occurs, ascending by word.
std::vector<std::pair<int, int>> CountWords(std::vector<int> words) {
  std::ranges::sort(words);
  std::vector<std::pair<int, int>> counts;
  for (const int word : words) {
    if (counts.empty() || counts.back().first != word) counts.emplace_back(word, 0);
    ++counts.back().second;
  }
  return counts;
}

// Where the postings of each word begin, and the last end.
std::vector<std::size_t> CountPostings(const std::vector<std::vector<int>>& words) {
  int max_word = -1;
  for (const auto& list : words) {
    for (const int word : list) max_word = std::max(max_word, word);
  }
  std::vector<std::size_t> begins(static_cast<std::size_t>(max_word + 1) + 1, 0);
  for (const auto& list : words) {
    for (const auto& [word, count] : CountWords(list)) {
      ++begins[static_cast<std::size_t>(word) + 1];
    }
  }
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  return begins;
}

bool IsBetter(const InvertedFile::Result& a, const InvertedFile::Result& b) {
  return a.score != b.score ? a.score > b.score : a.frame_idx < b.frame_idx;
}

}  // namespace

InvertedFile::InvertedFile(const std::vector<std::vector<int>>& words)
    : num_frames_(words.size()), begins_(CountPostings(words)) {
  postings_.resize(begins_.back());
  idf_.resize(begins_.size() - 1, 0.0F);
  std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
  for (std::size_t frame = 0; frame < words.size(); ++frame) {
    for (const auto& [word, count] : CountWords(words[frame])) {
      postings_[next[static_cast<std::size_t>(word)]++] = {static_cast<std::int32_t>(frame),
                                                           static_cast<float>(count)};
    }
  }
  std::vector<double> squared_norms(num_frames_, 0.0);
  for (std::size_t word = 0; word < NumWords(); ++word) {
    const std::size_t num_postings = begins_[word + 1] - begins_[word];
    if (num_postings == 0) continue;
    // Adds one, so that a map of one frame still scores.
    idf_[word] = static_cast<float>(
        std::log(static_cast<double>(num_frames_ + 1) / static_cast<double>(num_postings)));
    for (std::size_t i = begins_[word]; i < begins_[word + 1]; ++i) {
      Posting& posting = postings_[i];
      posting.weight *= idf_[word];
      squared_norms[static_cast<std::size_t>(posting.frame_idx)] +=
          static_cast<double>(posting.weight) * posting.weight;
    }
  }
  for (Posting& posting : postings_) {
    posting.weight /=
        static_cast<float>(std::sqrt(squared_norms[static_cast<std::size_t>(posting.frame_idx)]));
  }
}

std::vector<InvertedFile::Result> InvertedFile::Query(const std::vector<int>& words,
                                                      int count,
                                                      int before_frame_idx) const {
  const std::size_t end = before_frame_idx < 0
                              ? num_frames_
                              : std::min(num_frames_, static_cast<std::size_t>(before_frame_idx));
  std::vector<double> scores(end, 0.0);
  double squared_norm = 0;
  for (const auto& [word, num_occurrences] : CountWords(words)) {
    if (word < 0 || static_cast<std::size_t>(word) >= NumWords()) continue;
    const double weight =
        num_occurrences * static_cast<double>(idf_[static_cast<std::size_t>(word)]);
    squared_norm += weight * weight;
    for (const Posting& posting : Of(static_cast<std::size_t>(word))) {
      const auto frame = static_cast<std::size_t>(posting.frame_idx);
      if (frame >= end) break;
      scores[frame] += weight * static_cast<double>(posting.weight);
    }
  }
  std::vector<Result> results;
  for (std::size_t frame = 0; frame < end; ++frame) {
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
