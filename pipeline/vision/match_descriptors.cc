// SPDX-License-Identifier: Apache-2.0
#include "pipeline/vision/match_descriptors.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "pipeline/vision/descriptor_distance.h"

namespace nightmap {
namespace {

// Two best candidates of one feature so far.
struct Nearest {
  int index = -1;
  int distance = std::numeric_limits<int>::max();  // squared L2, or Hamming
  int second_distance = std::numeric_limits<int>::max();

  void Offer(int candidate, int candidate_distance) {
    if (candidate_distance < distance) {
      second_distance = distance;
      distance = candidate_distance;
      index = candidate;
    } else if (candidate_distance < second_distance) {
      second_distance = candidate_distance;
    }
  }
};

constexpr std::size_t kSiftSize = 128;

// Compiled for several instruction sets, of which the machine's best is taken when the program
// starts: sums of integers are the same with each.
[[gnu::target_clones("arch=skylake-avx512", "avx2", "default")]] void DotProducts(
    const std::int16_t* descriptor, const std::int16_t* others, std::size_t count, int* products) {
  for (std::size_t i = 0; i < count; ++i) {
    int sum = 0;
    for (std::size_t k = 0; k < kSiftSize; ++k) sum += descriptor[k] * others[i * kSiftSize + k];
    products[i] = sum;
  }
}

// Squared distances by |x|^2 + |y|^2 - 2 x y.
class SiftDistances {
 public:
  SiftDistances(const FrameFeatures& a, const FrameFeatures& b)
      : a_(a.descriptors.begin(), a.descriptors.end()),
        b_(b.descriptors.begin(), b.descriptors.end()),
        norms_b_(static_cast<std::size_t>(b.NumFeatures())) {
    for (std::size_t j = 0; j < norms_b_.size(); ++j) norms_b_[j] = SquaredNorm(&b_[j * kSiftSize]);
  }

  void Row(std::size_t i, std::vector<int>* distances) const {
    const std::int16_t* descriptor = &a_[i * kSiftSize];
    const int norm = SquaredNorm(descriptor);
    DotProducts(descriptor, b_.data(), norms_b_.size(), distances->data());
    for (std::size_t j = 0; j < norms_b_.size(); ++j) {
      (*distances)[j] = norm + norms_b_[j] - 2 * (*distances)[j];
    }
  }

 private:
  static int SquaredNorm(const std::int16_t* descriptor) {
    int norm = 0;
    DotProducts(descriptor, descriptor, 1, &norm);
    return norm;
  }

  std::vector<std::int16_t> a_, b_;
  std::vector<int> norms_b_;
};

class HammingDistances {
 public:
  HammingDistances(const FrameFeatures& a, const FrameFeatures& b, int size)
      : a_(a), b_(b), size_(static_cast<std::size_t>(size)) {}

  void Row(std::size_t i, std::vector<int>* distances) const {
    for (std::size_t j = 0; j < distances->size(); ++j) {
      int count = 0;
      for (std::size_t k = 0; k < size_; k += 8) {
        count += std::popcount(Word(a_, i, k) ^ Word(b_, j, k));
      }
      (*distances)[j] = count;
    }
  }

 private:
  std::uint64_t Word(const FrameFeatures& features, std::size_t feature, std::size_t offset) const {
    std::uint64_t bits;
    std::memcpy(&bits, features.descriptors.data() + feature * size_ + offset, sizeof(bits));
    return bits;
  }

  const FrameFeatures& a_;
  const FrameFeatures& b_;
  std::size_t size_;
};

template <typename Distances>
std::vector<FeatureMatch> Match(const FrameFeatures& a,
                                const FrameFeatures& b,
                                const Distances& distances,
                                DescriptorKind kind,
                                double max_ratio) {
  std::vector<Nearest> nearest_of_a(static_cast<std::size_t>(a.NumFeatures()));
  std::vector<Nearest> nearest_of_b(static_cast<std::size_t>(b.NumFeatures()));
  std::vector<int> row(nearest_of_b.size());
  for (std::size_t i = 0; i < nearest_of_a.size(); ++i) {
    distances.Row(i, &row);
    for (std::size_t j = 0; j < row.size(); ++j) {
      nearest_of_a[i].Offer(static_cast<int>(j), row[j]);
      nearest_of_b[j].Offer(static_cast<int>(i), row[j]);
    }
  }
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < nearest_of_a.size(); ++i) {
    const Nearest& best = nearest_of_a[i];
    const Nearest& back = nearest_of_b[static_cast<std::size_t>(best.index)];
    if (back.index == static_cast<int>(i) &&
        PassesRatioTest(kind, best.distance, best.second_distance, max_ratio)) {
      matches.push_back({static_cast<int>(i), best.index});
    }
  }
  return matches;
}

}  // namespace

std::vector<FeatureMatch> MatchDescriptors(const FrameFeatures& a,
                                           const FrameFeatures& b,
                                           DescriptorKind kind,
                                           double max_ratio) {
  if (a.NumFeatures() == 0 || b.NumFeatures() == 0) return {};
  if (kind == DescriptorKind::kRootSift) {
    return Match(a, b, SiftDistances(a, b), kind, max_ratio);
  }
  return Match(a, b, HammingDistances(a, b, DescriptorSize(kind)), kind, max_ratio);
}

}  // namespace nightmap
