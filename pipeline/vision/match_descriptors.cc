// SPDX-License-Identifier: Apache-2.0
#include "pipeline/vision/match_descriptors.h"

#include <bit>
#include <cstring>
#include <limits>

namespace nightmap {
namespace {

// Two best candidates of one feature so far.
struct Nearest {
  int index = -1;
  float distance = std::numeric_limits<float>::max();  // squared L2, or Hamming
  float second_distance = std::numeric_limits<float>::max();

  void Offer(int candidate, float candidate_distance) {
    if (candidate_distance < distance) {
      second_distance = distance;
      distance = candidate_distance;
      index = candidate;
    } else if (candidate_distance < second_distance) {
      second_distance = candidate_distance;
    }
  }
};

using FloatMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ByteMatrix =
    Eigen::Map<const Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 128, Eigen::RowMajor>>;

FloatMatrix ToFloat(const FrameFeatures& features) {
  return ByteMatrix(features.descriptors.data(), features.NumFeatures(), 128).cast<float>();
}

// Sums of products of bytes stay below 2^24, so float arithmetic is exact whatever the order.
FloatMatrix SquaredDistances(const FrameFeatures& a, const FrameFeatures& b) {
  const FloatMatrix descriptors_a = ToFloat(a);
  const FloatMatrix descriptors_b = ToFloat(b);
  FloatMatrix distances = -2.0f * (descriptors_a * descriptors_b.transpose());
  distances.colwise() += descriptors_a.rowwise().squaredNorm();
  distances.rowwise() += descriptors_b.rowwise().squaredNorm().transpose();
  return distances;
}

FloatMatrix HammingDistances(const FrameFeatures& a, const FrameFeatures& b, int size) {
  FloatMatrix distances(a.NumFeatures(), b.NumFeatures());
  const auto word = [size](const FrameFeatures& features, int feature, int offset) {
    std::uint64_t bits;
    std::memcpy(&bits, features.descriptors.data() + feature * size + offset, sizeof(bits));
    return bits;
  };
  for (int i = 0; i < a.NumFeatures(); ++i) {
    for (int j = 0; j < b.NumFeatures(); ++j) {
      int count = 0;
      for (int k = 0; k < size; k += 8) count += std::popcount(word(a, i, k) ^ word(b, j, k));
      distances(i, j) = static_cast<float>(count);
    }
  }
  return distances;
}

}  // namespace

std::vector<FeatureMatch> MatchDescriptors(const FrameFeatures& a,
                                           const FrameFeatures& b,
                                           DescriptorKind kind,
                                           double max_ratio) {
  if (a.NumFeatures() == 0 || b.NumFeatures() == 0) return {};
  const bool is_squared = kind == DescriptorKind::kRootSift;
  const FloatMatrix distances =
      is_squared ? SquaredDistances(a, b) : HammingDistances(a, b, DescriptorSize(kind));
  std::vector<Nearest> nearest_of_a(static_cast<std::size_t>(a.NumFeatures()));
  std::vector<Nearest> nearest_of_b(static_cast<std::size_t>(b.NumFeatures()));
  for (int i = 0; i < a.NumFeatures(); ++i) {
    for (int j = 0; j < b.NumFeatures(); ++j) {
      nearest_of_a[static_cast<std::size_t>(i)].Offer(j, distances(i, j));
      nearest_of_b[static_cast<std::size_t>(j)].Offer(i, distances(i, j));
    }
  }
  const auto ratio = static_cast<float>(is_squared ? max_ratio * max_ratio : max_ratio);
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < a.NumFeatures(); ++i) {
    const Nearest& best = nearest_of_a[static_cast<std::size_t>(i)];
    const Nearest& back = nearest_of_b[static_cast<std::size_t>(best.index)];
    if (back.index == i && best.distance < ratio * best.second_distance) {
      matches.push_back({i, best.index});
    }
  }
  return matches;
}

}  // namespace nightmap
