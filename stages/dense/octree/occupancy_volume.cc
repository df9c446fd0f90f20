// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/occupancy_volume.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "pipeline/base/parallel.h"
#include "pipeline/dense/octree_leaves.h"

namespace nightmap {
namespace {

// The blocks of one keyframe that lie in one region.
struct RegionRun {
  std::uint64_t region = 0;
  const KeyframeEvidence* keyframe = nullptr;
  std::size_t begin = 0;
  std::size_t end = 0;
};

// Runs by region, and within a region in the order of the keyframes.
std::vector<RegionRun> SplitByRegion(std::span<const KeyframeEvidence> keyframes) {
  std::vector<RegionRun> runs;
  for (const KeyframeEvidence& keyframe : keyframes) {
    for (std::size_t i = 0; i < keyframe.blocks.size(); ++i) {
      const std::uint64_t region = BlockOf(keyframe.blocks[i].block);
      if (i == 0 || region != runs.back().region) runs.push_back({region, &keyframe, i, i});
      ++runs.back().end;
    }
  }
  std::ranges::stable_sort(runs, {}, &RegionRun::region);
  return runs;
}

}  // namespace

OccupancyVolume::OccupancyVolume(const SensorModel& model)
    : model_(model), of_hit_(MakeUpdates(model.hit)), of_miss_(MakeUpdates(model.miss)) {}

OccupancyVolume::Updates OccupancyVolume::MakeUpdates(float log_odds) {
  Updates updates;
  for (unsigned bits = 0; bits < updates.size(); ++bits) {
    for (unsigned i = 0; i < 4; ++i) updates[bits][i] = (bits >> i & 1) != 0 ? log_odds : 0;
  }
  return updates;
}

void OccupancyVolume::Integrate(std::span<const KeyframeEvidence> keyframes, int num_threads) {
  const std::vector<RegionRun> runs = SplitByRegion(keyframes);
  std::vector<std::pair<Region*, std::span<const RegionRun>>> work;
  for (std::size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
    while (end < runs.size() && runs[end].region == runs[begin].region) ++end;
    work.emplace_back(&regions_[runs[begin].region], std::span(runs).subspan(begin, end - begin));
  }
  ParallelFor(work.size(), num_threads, [&](std::size_t i) {
    Region& region = *work[i].first;
    for (const RegionRun& run : work[i].second) {
      for (std::size_t b = run.begin; b < run.end; ++b) {
        const auto& [code, evidence] = run.keyframe->blocks[b];
        std::unique_ptr<Block>& block = region[IndexInBlock(code)];
        if (!block) block = std::make_unique<Block>();
        Update(evidence, *block);
        if (evidence.hit.None()) continue;
        block->colors.Add(evidence.hit, &run.keyframe->colors[evidence.first_color]);
      }
    }
  });
}

void OccupancyVolume::Update(const BlockEvidence& evidence, Block& block) const {
  block.known |= evidence.hit;
  block.known |= evidence.passed;
  for (std::size_t word = 0; word < kBlockWords; ++word) {
    const std::uint64_t hit = evidence.hit.words[word];
    const std::uint64_t passed = evidence.passed.words[word];
    if (hit == 0 && (passed == 0 || block.settled[word])) continue;
    Eigen::Array4f highest = Eigen::Array4f::Constant(model_.min);
    for (std::size_t i = 0; i < 64; i += 4) {
      Eigen::Map<Eigen::Array4f, Eigen::Aligned16> values(&block.log_odds[64 * word + i]);
      values = (values + of_hit_[hit >> i & 15] + of_miss_[passed >> i & 15])
                   .min(model_.max)
                   .max(model_.min);
      highest = highest.max(values);
    }
    block.settled[word] = highest.maxCoeff() == model_.min;
  }
}

OccupancyTree OccupancyVolume::Leaves(double resolution_m, int num_threads) const {
  std::vector<std::pair<std::uint64_t, const Region*>> regions;
  for (const auto& [code, region] : regions_) regions.emplace_back(code, &region);
  std::vector<LeafList> lists(regions.size());
  ParallelFor(regions.size(), num_threads, [&](std::size_t i) {
    const auto& [region_code, region] = regions[i];
    for (std::size_t b = 0; b < kBlockVoxels; ++b) {
      if (!(*region)[b]) continue;
      const Block& block = *(*region)[b];
      const std::uint64_t first = (region_code << kBlockShift | b) << kBlockShift;
      block.known.ForEach([&](std::size_t index) {
        PlacedLeaf leaf{first | index, block.log_odds[index] - model_.threshold};
        if (leaf.Occupied()) {
          if (block.colors.NumKeyframes(index) < model_.min_keyframes) return;
          leaf.rgb = block.colors.Mean(index);
        }
        lists[i].Append(leaf);
      });
    }
  });
  LeafList all;
  for (LeafList& list : lists) {
    for (const PlacedLeaf& leaf : list.Leaves()) all.Append(leaf);
    list = {};
  }
  return all.Tree(resolution_m);
}

}  // namespace nightmap
