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
  postings_.frames.resize(begins_.back());
  postings_.weights.resize(begins_.back());
  SetInverseFrequencies();
  std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
  for (std::size_t frame = 0; frame < words.size(); ++frame) {
    for (const auto& [word, count] : CountWords(words[frame])) {
      const std::size_t i = next[static_cast<std::size_t>(word)]++;
      postings_.frames[i] = static_cast<std::int32_t>(frame);
      postings_.weights[i] = static_cast<float>(count);
    }
  }
  std::vector<double> squared_norms(num_frames_, 0.0);
  for (std::size_t word = 0; word < NumWords(); ++word) {
    for (std::size_t i = begins_[word]; i < begins_[word + 1]; ++i) {
      float& weight = postings_.weights[i];
      weight *= idf_[word];
      squared_norms[static_cast<std::size_t>(postings_.frames[i])] +=
          static_cast<double>(weight) * weight;
    }
  }
  for (std::size_t i = 0; i < begins_.back(); ++i) {
    postings_.weights[i] /=
        static_cast<float>(std::sqrt(squared_norms[static_cast<std::size_t>(postings_.frames[i])]));
  }
}

InvertedFile::InvertedFile(std::size_t num_frames,
                           std::vector<std::size_t> begins,
                           ReadPostings read)
    : num_frames_(num_frames), begins_(std::move(begins)), read_(std::move(read)) {
  SetInverseFrequencies();
}

void InvertedFile::SetInverseFrequencies() {
  idf_.resize(begins_.size() - 1, 0.0F);
  for (std::size_t word = 0; word < NumWords(); ++word) {
    if (NumPostings(word) == 0) continue;
    // Adds one, so that a map of one frame still scores.
    idf_[word] = static_cast<float>(
        std::log(static_cast<double>(num_frames_ + 1) / static_cast<double>(NumPostings(word))));
  }
}

InvertedFile::Bag InvertedFile::KnownWords(const std::vector<int>& words) const {
  Bag bag = CountWords(words);
  std::erase_if(bag, [&](const auto& counted) {
    return counted.first < 0 || static_cast<std::size_t>(counted.first) >= NumWords();
  });
  return bag;
}

std::vector<InvertedFile::Result> InvertedFile::Query(const std::vector<int>& words,
                                                      int count,
                                                      int before_frame_idx) const {
  const std::size_t end = before_frame_idx < 0
                              ? num_frames_
                              : std::min(num_frames_, static_cast<std::size_t>(before_frame_idx));
  return Best(KnownWords(words), count, end);
}

std::vector<InvertedFile::Result> InvertedFile::QueryRarest(const std::vector<int>& words,
                                                            int count,
                                                            std::size_t min_words,
                                                            std::size_t max_postings) const {
  Bag bag = KnownWords(words);
  const auto size = [&](const auto& counted) {
    return NumPostings(static_cast<std::size_t>(counted.first));
  };
  std::ranges::stable_sort(bag, {}, size);
  std::size_t num_postings = 0, num_words = 0;
  while (num_words < bag.size() &&
         (num_words < min_words || num_postings + size(bag[num_words]) <= max_postings)) {
    num_postings += size(bag[num_words++]);
  }
  bag.resize(num_words);
  std::ranges::sort(bag);
  return Best(bag, count, num_frames_);
}

std::vector<InvertedFile::Result> InvertedFile::Best(const Bag& bag,
                                                     int count,
                                                     std::size_t end) const {
  std::vector<double> scores(end, 0.0);
  double squared_norm = 0;
  Postings postings;
  const auto add = [&](std::span<const std::int32_t> frames, const float* weights, double weight) {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto frame = static_cast<std::size_t>(frames[i]);
      if (frame >= end) break;
      scores[frame] += weight * static_cast<double>(weights[i]);
    }
  };
  for (const auto& [word, num_occurrences] : bag) {
    const auto w = static_cast<std::size_t>(word);
    const double weight = num_occurrences * static_cast<double>(idf_[w]);
    squared_norm += weight * weight;
    if (read_) {
      read_(begins_[w], begins_[w + 1], &postings);
      add(postings.frames, postings.weights.data(), weight);
    } else {
      add(std::span(postings_.frames).subspan(begins_[w], NumPostings(w)),
          postings_.weights.data() + begins_[w],
          weight);
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
  // A copy, because the list of all frames with a score is as long as the site.
  return {results.begin(), results.begin() + static_cast<std::ptrdiff_t>(num_kept)};
}

}  // namespace nightmap
