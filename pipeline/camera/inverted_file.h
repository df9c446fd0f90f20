// SPDX-License-Identifier: Apache-2.0
// Inverted file over the leaf words of a set of images, scored by tf-idf cosine (Sivic and
// Zisserman, ICCV 2003; Nister and Stewenius, CVPR 2006).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace nightmap {

// Const after construction: threads may share one.
class InvertedFile {
 public:
  struct Result {
    int frame_idx = 0;
    double score = 0;  // in [0, 1]
  };
  // words[i]: leaf words of frame i's features. They need not outlive it.
  InvertedFile() = default;
  explicit InvertedFile(const std::vector<std::vector<int>>& words);
  // The best `count` frames that share a word with a bag of words, best first, ties by frame index.
  // Only frames with index below `before_frame_idx` (negative: all). Ignores words never seen.
  std::vector<Result> Query(const std::vector<int>& words,
                            int count,
                            int before_frame_idx = -1) const;

 private:
  struct Posting {
    std::int32_t frame_idx = 0;
    float weight = 0;
  };
  std::span<const Posting> Of(std::size_t word) const {
    return {postings_.data() + begins_[word], postings_.data() + begins_[word + 1]};
  }
  std::size_t NumWords() const { return idf_.size(); }

  std::size_t num_frames_ = 0;
  std::vector<Posting> postings_;    // by word, then by frame
  std::vector<std::size_t> begins_;  // of each word, and the end
  std::vector<float> idf_;
};

}  // namespace nightmap
