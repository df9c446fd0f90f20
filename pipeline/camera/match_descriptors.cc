// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/match_descriptors.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "pipeline/camera/descriptor_distance.h"

namespace nightmap {
namespace {

// The two best candidates so far for every feature of an image. Plain loops over arrays of
// integers, which the compiler vectorizes.
class Nearest {
 public:
  explicit Nearest(int num_features)
      : index_(static_cast<std::size_t>(num_features), -1),
        distance_(index_.size(), std::numeric_limits<int>::max()),
        second_distance_(index_.size(), std::numeric_limits<int>::max()) {}

  // Offers one candidate, by its distance to every feature.
  void OfferToAll(int candidate, const int* distances) {
    int* const index = index_.data();
    int* const nearest = distance_.data();
    int* const second = second_distance_.data();
    for (std::size_t j = 0; j < index_.size(); ++j) {
      const int distance = distances[j];
      const int best = nearest[j];
      second[j] = std::min(second[j], std::max(best, distance));
      index[j] = distance < best ? candidate : index[j];
      nearest[j] = std::min(best, distance);
    }
  }

  // Offers all candidates to one feature, by their distances.
  void OfferAll(std::size_t feature, const int* distances, std::size_t count) {
    const int nearest = Smallest(distances, count);
    const auto at =
        static_cast<std::size_t>(std::find(distances, distances + count, nearest) - distances);
    index_[feature] = static_cast<int>(at);
    distance_[feature] = nearest;
    second_distance_[feature] =
        std::min(Smallest(distances, at), Smallest(distances + at + 1, count - at - 1));
  }

  int Index(std::size_t feature) const { return index_[feature]; }
  bool Passes(std::size_t feature, DescriptorKind kind, double max_ratio) const {
    return PassesRatioTest(kind, distance_[feature], second_distance_[feature], max_ratio);
  }

 private:
  static int Smallest(const int* values, std::size_t count) {
    int smallest = std::numeric_limits<int>::max();
    for (std::size_t i = 0; i < count; ++i) smallest = std::min(smallest, values[i]);
    return smallest;
  }

  std::vector<int> index_, distance_, second_distance_;
};

constexpr std::size_t kSiftSize = 128;
constexpr std::size_t kBlock = 4;  // rows computed together

// products[r * count + i] = descriptors[r] . others[i] of kBlock descriptors. Compiled for several
// instruction sets; the program chooses the machine's best at its start. Sums of integers are the
// same with each. Blocks save time, because reading `others` takes most of it.
[[gnu::target_clones("arch=skylake-avx512", "avx2", "default")]] void DotProducts(
    const std::int16_t* descriptors, const std::int16_t* others, std::size_t count, int* products) {
  const std::int16_t* const a = descriptors;
  const std::int16_t* const b = a + kSiftSize;
  const std::int16_t* const c = b + kSiftSize;
  const std::int16_t* const d = c + kSiftSize;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int16_t* const other = others + i * kSiftSize;
    int sum_a = 0, sum_b = 0, sum_c = 0, sum_d = 0;
    for (std::size_t k = 0; k < kSiftSize; ++k) {
      sum_a += a[k] * other[k];
      sum_b += b[k] * other[k];
      sum_c += c[k] * other[k];
      sum_d += d[k] * other[k];
    }
    products[i] = sum_a;
    products[count + i] = sum_b;
    products[2 * count + i] = sum_c;
    products[3 * count + i] = sum_d;
  }
}

// Squared distances by |x|^2 + |y|^2 - 2 x y.
class SiftDistances {
 public:
  SiftDistances(const FrameFeatures& a, const FrameFeatures& b)
      : a_(Widen(a)), b_(Widen(b)), norms_a_(SquaredNorms(a)), norms_b_(SquaredNorms(b)) {}

  // Distances of the features first .. first + kBlock of a to all of b. Rows beyond the last
  // feature are meaningless.
  void Rows(std::size_t first, int* distances) const {
    const std::size_t count = norms_b_.size();
    DotProducts(&a_[first * kSiftSize], b_.data(), count, distances);
    for (std::size_t row = 0; row < std::min(kBlock, norms_a_.size() - first); ++row) {
      int* const own = distances + row * count;
      for (std::size_t j = 0; j < count; ++j)
        own[j] = norms_a_[first + row] + norms_b_[j] - 2 * own[j];
    }
  }

 private:
  // Padded to whole blocks.
  static std::vector<std::int16_t> Widen(const FrameFeatures& features) {
    std::vector<std::int16_t> wide(features.descriptors.begin(), features.descriptors.end());
    wide.resize(wide.size() + (kBlock - 1) * kSiftSize);
    return wide;
  }
  static std::vector<int> SquaredNorms(const FrameFeatures& features) {
    std::vector<int> norms;
    for (int i = 0; i < features.NumFeatures(); ++i) {
      const std::uint8_t* descriptor =
          &features.descriptors[static_cast<std::size_t>(i) * kSiftSize];
      int norm = 0;
      for (std::size_t k = 0; k < kSiftSize; ++k) norm += descriptor[k] * descriptor[k];
      norms.push_back(norm);
    }
    return norms;
  }

  std::vector<std::int16_t> a_, b_;
  std::vector<int> norms_a_, norms_b_;
};

class HammingDistances {
 public:
  HammingDistances(const FrameFeatures& a, const FrameFeatures& b, int size)
      : a_(a), b_(b), size_(static_cast<std::size_t>(size)) {}

  void Rows(std::size_t first, int* distances) const {
    const auto num_a = static_cast<std::size_t>(a_.NumFeatures());
    for (std::size_t i = first; i < std::min(first + kBlock, num_a); ++i) {
      for (int j = 0; j < b_.NumFeatures(); ++j) {
        int count = 0;
        for (std::size_t k = 0; k < size_; k += 8) {
          count += std::popcount(Word(a_, i, k) ^ Word(b_, static_cast<std::size_t>(j), k));
        }
        *distances++ = count;
      }
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
  Nearest nearest_of_a(a.NumFeatures());
  Nearest nearest_of_b(b.NumFeatures());
  const auto count = static_cast<std::size_t>(b.NumFeatures());
  std::vector<int> rows(kBlock * count);
  for (int i = 0; i < a.NumFeatures(); ++i) {
    const auto feature = static_cast<std::size_t>(i);
    if (feature % kBlock == 0) distances.Rows(feature, rows.data());
    const int* const row = &rows[feature % kBlock * count];
    nearest_of_a.OfferAll(feature, row, count);
    nearest_of_b.OfferToAll(i, row);
  }
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < a.NumFeatures(); ++i) {
    const auto feature = static_cast<std::size_t>(i);
    const int best = nearest_of_a.Index(feature);
    if (nearest_of_b.Index(static_cast<std::size_t>(best)) == i &&
        nearest_of_a.Passes(feature, kind, max_ratio)) {
      matches.push_back({i, best});
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
