// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/voxel_labels/spread_votes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

constexpr std::size_t kNumNeighbours = 18;  // that share a face or an edge
constexpr float kUnseenBond = 0.05F;        // of a voxel that nobody saw
constexpr float kUnseenWeight = 0.1F;       // of all its votes

struct Bond {
  std::uint32_t neighbour = 0;
  float strength = 0;  // 0: no such neighbour
};
using Bonds = std::array<Bond, kNumNeighbours>;

std::vector<VoxelKey> NeighbourOffsets() {
  std::vector<VoxelKey> offsets;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const int num_axes = std::abs(x) + std::abs(y) + std::abs(z);
        if (num_axes == 1 || num_axes == 2) offsets.emplace_back(x, y, z);
      }
    }
  }
  return offsets;
}

class Spreading {
 public:
  Spreading(const SpreadOptions& options, int num_threads, VoteTable* votes)
      : options_(options), num_threads_(num_threads), votes_(*votes), sums_(votes->codes.size()) {
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      sums_[i] = std::accumulate(VotesOf(i), VotesOf(i + 1), 0.0F);
    }
    bonds_.resize(sums_.size());
    std::vector<std::uint8_t> is_settled(sums_.size());
    ParallelForShort(sums_.size(), num_threads_, [&](std::size_t i) {
      FindBonds(i);
      is_settled[i] = IsSettled(i) ? 1 : 0;
    });
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      if (is_settled[i] == 0) unsettled_.push_back(i);
    }
  }

  void Run() {
    shares_ = votes_.weights;
    ParallelForShort(sums_.size(), num_threads_, [&](std::size_t i) { Scale(i, 1, &shares_); });
    std::vector<float> next = shares_;
    for (int iteration = 0; iteration < options_.spread_iterations; ++iteration) {
      ParallelForShort(
          unsettled_.size(), num_threads_, [&](std::size_t u) { Step(unsettled_[u], &next); });
      std::swap(shares_, next);
    }
    ParallelForShort(sums_.size(), num_threads_, [&](std::size_t i) {
      Scale(i, sums_[i] > 0 ? sums_[i] : kUnseenWeight, &shares_);
    });
    votes_.weights = std::move(shares_);
  }

 private:
  const float* VotesOf(std::size_t i) const {
    return votes_.weights.data() + i * votes_.num_classes;
  }

  // Makes the sum of a voxel's values `sum`, unless all are 0.
  void Scale(std::size_t i, float sum, std::vector<float>* values) const {
    float* const begin = values->data() + i * votes_.num_classes;
    float* const end = begin + votes_.num_classes;
    const float before = std::accumulate(begin, end, 0.0F);
    if (before <= 0) return;
    for (float* value = begin; value != end; ++value) *value *= sum / before;
  }

  float Strength(std::size_t i, std::size_t j) const {
    if (sums_[i] <= 0 || sums_[j] <= 0) return kUnseenBond;
    const float* const a = VotesOf(i);
    const float* const b = VotesOf(j);
    float ab = 0, aa = 0, bb = 0;
    for (std::size_t c = 0; c < votes_.num_classes; ++c) {
      ab += a[c] * b[c];
      aa += a[c] * a[c];
      bb += b[c] * b[c];
    }
    const float cosine2 = ab * ab / (aa * bb);
    return cosine2 * cosine2;
  }

  void FindBonds(std::size_t i) {
    static const std::vector<VoxelKey> offsets = NeighbourOffsets();
    const VoxelKey key = KeyOfMortonCode(votes_.codes[i]);
    for (std::size_t k = 0; k < kNumNeighbours; ++k) {
      const VoxelKey neighbour = key + offsets[k];
      constexpr int kReach = 1 << 15;
      if (neighbour.minCoeff() < -kReach || neighbour.maxCoeff() >= kReach) continue;
      const auto found = std::ranges::lower_bound(votes_.codes, MortonCode(neighbour));
      if (found == votes_.codes.end() || *found != MortonCode(neighbour)) continue;
      const auto j = static_cast<std::size_t>(found - votes_.codes.begin());
      bonds_[i][k] = {static_cast<std::uint32_t>(j), Strength(i, j)};
    }
  }

  // Whether all votes on voxel i and its neighbours are for one class.
  bool IsSettled(std::size_t i) const {
    if (sums_[i] <= 0) return false;
    const float* const votes = VotesOf(i);
    const auto c = std::max_element(votes, VotesOf(i + 1)) - votes;
    const auto is_only = [&](std::size_t j) { return VotesOf(j)[c] == sums_[j]; };
    return is_only(i) && std::ranges::all_of(bonds_[i], [&](const Bond& bond) {
             return bond.strength == 0 || is_only(bond.neighbour);
           });
  }

  // The shares of voxel i that fit its votes and its neighbours' shares best.
  void Step(std::size_t i, std::vector<float>* next) const {
    const std::size_t num_classes = votes_.num_classes;
    float* const result = next->data() + i * num_classes;
    std::copy(VotesOf(i), VotesOf(i + 1), result);
    float sum = sums_[i];
    for (const Bond& bond : bonds_[i]) {
      const float weight = static_cast<float>(options_.spread_weight) * bond.strength;
      if (weight <= 0) continue;
      sum += weight;
      const float* const shares = shares_.data() + bond.neighbour * num_classes;
      for (std::size_t c = 0; c < num_classes; ++c) result[c] += weight * shares[c];
    }
    for (std::size_t c = 0; c < num_classes && sum > 0; ++c) result[c] /= sum;
  }

  const SpreadOptions& options_;
  int num_threads_;
  VoteTable& votes_;
  std::vector<float> sums_;  // of the votes of a voxel
  std::vector<Bonds> bonds_;
  std::vector<std::size_t> unsettled_;  // the voxels that may change
  std::vector<float> shares_;
};

}  // namespace

void SpreadVotes(const SpreadOptions& options, int num_threads, VoteTable* votes) {
  if (options.spread_iterations == 0 || options.spread_weight <= 0) return;
  Spreading(options, num_threads, votes).Run();
}

}  // namespace nightmap
