// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/occupancy_volume.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "pipeline/base/random.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap::occupancy_volume_test {

constexpr double kResolution_m = 0.1;

// Keyframes that hit and pass voxels at random in a few blocks, some in other regions; `density` of
// the voxels of a block are passed.
std::vector<KeyframeEvidence> RandomKeyframes(std::size_t num_keyframes, double density) {
  Random random(3);
  std::vector<KeyframeEvidence> keyframes(num_keyframes);
  for (KeyframeEvidence& keyframe : keyframes) {
    for (int i = -10; i < 60; i += 5) {
      if (random.Uniform(0, 1) < 0.2) continue;
      BlockMap<BlockEvidence>::Entry entry;
      entry.block = BlockOf(MortonCode({8 * i, 8 * (i % 3), 16 * (i % 2)}));
      entry.value.first_color = static_cast<std::uint32_t>(keyframe.colors.size());
      for (std::size_t index = 0; index < kBlockVoxels; ++index) {
        if (random.Uniform(0, 1) < 0.05) {
          entry.value.hit.Set(index);
          const auto value = static_cast<std::uint32_t>(random.Index(256));
          keyframe.colors.push_back({{value, value / 2, 3}, 1});
        } else if (random.Uniform(0, 1) < density) {
          entry.value.passed.Set(index);
        }
      }
      keyframe.blocks.push_back(entry);
    }
    std::ranges::sort(keyframe.blocks, {}, [](const auto& entry) { return entry.block; });
  }
  return keyframes;
}

struct Voxel {
  float log_odds = 0;
  int num_hits = 0;
  ColorSum color;
};

// The rule as documented, voxel by voxel.
std::map<std::uint64_t, Voxel> Expected(const std::vector<KeyframeEvidence>& keyframes,
                                        const SensorModel& model) {
  std::map<std::uint64_t, Voxel> voxels;
  for (const KeyframeEvidence& keyframe : keyframes) {
    for (const auto& [block, evidence] : keyframe.blocks) {
      std::size_t color = evidence.first_color;
      for (std::size_t index = 0; index < kBlockVoxels; ++index) {
        const bool hit = evidence.hit.Test(index);
        if (!hit && !evidence.passed.Test(index)) continue;
        Voxel& voxel = voxels[block << kBlockShift | index];
        voxel.log_odds += hit ? model.hit : model.miss;
        voxel.log_odds = std::clamp(voxel.log_odds, model.min, model.max);
        if (!hit) continue;
        ++voxel.num_hits;
        voxel.color.Add(keyframe.colors[color++]);
      }
    }
  }
  std::erase_if(voxels, [&](const auto& entry) {
    const Voxel& voxel = entry.second;
    return voxel.log_odds >= model.threshold && voxel.num_hits < model.min_keyframes;
  });
  return voxels;
}

void ExpectTheRule(const SensorModel& model) {
  for (const double density : {0.3, 1.0}) {
    const auto keyframes = RandomKeyframes(25, density);
    const auto expected = Expected(keyframes, model);
    OccupancyVolume volume(model);
    volume.Integrate(std::span(keyframes).first(3), 1);
    volume.Integrate(std::span(keyframes).subspan(3), 2);
    const OccupancyTree tree = volume.Leaves(kResolution_m, 2);
    std::size_t num_voxels = 0;
    for (const OccupancyVoxel& leaf : tree.leaves) {
      const auto edge = static_cast<std::uint64_t>(std::lround(leaf.size_m / kResolution_m));
      const Eigen::Vector3d first_centre =
          leaf.centre_in_map.array() - (leaf.size_m - kResolution_m) / 2;
      const std::uint64_t first = MortonCode(VoxelOf(first_centre, kResolution_m));
      for (std::uint64_t code = first; code < first + edge * edge * edge; ++code, ++num_voxels) {
        ASSERT_EQ(expected.count(code), 1U);
        const Voxel& voxel = expected.at(code);
        ASSERT_EQ(leaf.log_odds, voxel.log_odds - model.threshold);
        ASSERT_EQ(leaf.Occupied(), voxel.log_odds >= model.threshold);
        if (leaf.Occupied()) {
          ASSERT_EQ(leaf.rgb, voxel.color.Mean());
        }
      }
    }
    EXPECT_EQ(num_voxels, expected.size());
  }
}

TEST(OccupancyVolume, AppliesEachKeyframeOnceAVoxelInOrder) {
  ExpectTheRule({0.85F, -0.4F, -2.0F, 1.5F});
}

TEST(OccupancyVolume, OccupiedIsWhatReachesTheThresholdByEnoughKeyframes) {
  for (const float threshold : {-0.9F, 0.0F, 0.85F, 1.5F}) {
    for (const int min_keyframes : {1, 2, 4}) {
      ExpectTheRule({0.85F, -0.4F, -2.0F, 1.5F, threshold, min_keyframes});
    }
  }
}

TEST(OccupancyVolume, CountsOfKeyframesEndAtTheMost) {
  KeyframeEvidence keyframe;
  keyframe.blocks.push_back({BlockOf(MortonCode({0, 0, 0})), {}});
  keyframe.blocks[0].value.hit.Set(3);
  keyframe.colors.push_back({{1, 2, 3}, 1});
  SensorModel model;
  model.min_keyframes = BlockColors::kMaxKeyframes;
  OccupancyVolume volume(model);
  for (int i = 1; i <= 2 * BlockColors::kMaxKeyframes + 3; ++i) {
    volume.Integrate(std::span(&keyframe, 1), 1);
    const bool is_there = !volume.Leaves(kResolution_m, 1).leaves.empty();
    ASSERT_EQ(is_there, i >= model.min_keyframes) << i;
  }
}

TEST(OccupancyVolume, WhatIsAllFreeBecomesOneLeaf) {
  KeyframeEvidence keyframe;
  for (std::uint64_t i = 0; i < 8; ++i) {
    BlockMap<BlockEvidence>::Entry entry;
    entry.block = (BlockOf(MortonCode({0, 0, 0})) | i);
    entry.value.passed.words.fill(~std::uint64_t{0});
    keyframe.blocks.push_back(entry);
  }
  OccupancyVolume volume({});
  for (int i = 0; i < 7; ++i) volume.Integrate(std::span(&keyframe, 1), 1);
  const OccupancyTree tree = volume.Leaves(kResolution_m, 1);
  ASSERT_EQ(tree.leaves.size(), 1U);
  EXPECT_DOUBLE_EQ(tree.leaves[0].size_m, 1.6);
  EXPECT_EQ(tree.leaves[0].log_odds, -2.0F);
}

TEST(OccupancyVolume, AMeasuredWhiteIsNoMissingColor) {
  const ColorSum white{{510, 510, 510}, 2};
  EXPECT_EQ(white.Mean(), (std::array<std::uint8_t, 3>{255, 255, 254}));
  const ColorSum grey{{255, 254, 3}, 2};
  EXPECT_EQ(grey.Mean(), (std::array<std::uint8_t, 3>{128, 127, 2}));
}

}  // namespace nightmap::occupancy_volume_test
