// SPDX-License-Identifier: Apache-2.0
// Inverted file over the leaf words of a set of images, scored by tf-idf cosine (Sivic and
// Zisserman, ICCV 2003; Nister and Stewenius, CVPR 2006).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace nightmap {

// Const after construction: threads may share one.
class InvertedFile {
 public:
  struct Result {
    int frame_idx = 0;
    double score = 0;  // in [0, 1]
  };
  // Frames that have a word, ascending, and its weight in each; or those of several words in turn.
  struct Postings {
    std::vector<std::int32_t> frames;
    std::vector<float> weights;
  };
  // Replaces `postings`, whose memory it uses again, by postings [begin, end) of all. Threads call
  // it at the same time.
  using ReadPostings = std::function<void(std::size_t begin, std::size_t end, Postings* postings)>;

  InvertedFile() = default;
  // words[i]: leaf words of frame i's features. They need not outlive it.
  explicit InvertedFile(const std::vector<std::vector<int>>& words);
  // The same inverted file with the postings elsewhere, read for each query. `begins`: of the
  // postings of each word, and the end.
  InvertedFile(std::size_t num_frames, std::vector<std::size_t> begins, ReadPostings read);

  // The best `count` frames that share a word with a bag of words, best first, ties by frame index.
  // Only frames with index below `before_frame_idx` (negative: all). Ignores words never seen.
  std::vector<Result> Query(const std::vector<int>& words,
                            int count,
                            int before_frame_idx = -1) const;

  // Likewise, of all frames, by the rarest of the words, which tell places apart: as many as have
  // `max_postings` in all, and at least `min_words`. So a query costs hardly more in a
  // larger map.
  std::vector<Result> QueryRarest(const std::vector<int>& words,
                                  int count,
                                  std::size_t min_words,
                                  std::size_t max_postings) const;

  std::size_t NumFrames() const { return num_frames_; }
  const std::vector<std::size_t>& Begins() const { return begins_; }
  // Those in memory.
  const Postings& AllPostings() const { return postings_; }

 private:
  using Bag = std::vector<std::pair<int, int>>;  // words, and how often each occurs

  Bag KnownWords(const std::vector<int>& words) const;  // ascending
  std::vector<Result> Best(const Bag& bag, int count, std::size_t end_frame) const;
  std::size_t NumWords() const { return idf_.size(); }
  std::size_t NumPostings(std::size_t word) const { return begins_[word + 1] - begins_[word]; }
  void SetInverseFrequencies();

  std::size_t num_frames_ = 0;
  std::vector<std::size_t> begins_{0};
  Postings postings_;  // by word; empty when they are elsewhere
  ReadPostings read_;  // empty when they are in memory
  std::vector<float> idf_;
};

}  // namespace nightmap
