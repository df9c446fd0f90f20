// SPDX-License-Identifier: Apache-2.0
// A priority queue for searches whose keys rarely fall. Buckets of keys form a ring (Dial,
// Algorithm 360, 1969); within a bucket entries come out last in, first out (Yatziv, Bartesaghi and
// Sapiro, O(N) implementation of the fast marching algorithm, 2006).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace nightmap {

// Entries come out in order of key >> shift. An entry with a key below the current bucket goes into
// the current bucket. Keys are >= 0. Deterministic.
template <typename Entry>
class BucketQueue {
 public:
  // `max_rise`: largest rise of a pushed key above the current key; a higher key counts as that.
  BucketQueue(int shift, std::int64_t max_rise) : shift_(shift) {
    std::size_t size = 2;
    while (static_cast<std::int64_t>(size) < (max_rise >> shift) + 2) size *= 2;
    ring_.resize(size);
  }

  void Push(std::int64_t key, const Entry& entry) {
    if (at_ < 0) at_ = key >> shift_;
    const std::int64_t last = at_ + static_cast<std::int64_t>(ring_.size()) - 1;
    Bucket(std::clamp(key >> shift_, at_, last)).push_back(entry);
    ++size_;
  }

  bool IsEmpty() const { return size_ == 0; }

  // The queue must not be empty. No entry has a key below MinKey if no key fell.
  std::int64_t MinKey() {
    while (Bucket(at_).empty()) ++at_;
    return at_ << shift_;
  }
  Entry Pop() {
    std::vector<Entry>& bucket = Bucket(MinKey() >> shift_);
    const Entry entry = bucket.back();
    bucket.pop_back();
    --size_;
    return entry;
  }

 private:
  std::vector<Entry>& Bucket(std::int64_t bucket) {
    return ring_[static_cast<std::size_t>(bucket) & (ring_.size() - 1)];
  }

  int shift_;
  std::int64_t at_ = -1;  // current bucket; -1 before the first entry
  std::size_t size_ = 0;
  std::vector<std::vector<Entry>> ring_;
};

}  // namespace nightmap
