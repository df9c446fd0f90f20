// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/split_steps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace nightmap::split_steps_test {

constexpr double kVoxel_m = 0.05;

// The fronts of shelves in a row along x, and the space above them.
class SplitStepsTest : public testing::Test {
 protected:
  void AddFront(int begin, int end, int height, bool is_seen_above = true) {
    for (int x = begin; x < end; ++x) {
      for (int z = 0; z < height; ++z) {
        log_odds_[MortonCode({x, 0, z})] = 1;
        shelf_.voxels.push_back(voxels_.keys.size());
        voxels_.keys.push_back({x, 0, z});
      }
      for (int z = height; is_seen_above && z < 40; ++z) log_odds_[MortonCode({x, 0, z})] = -1;
    }
  }

  std::vector<std::size_t> SizesOfParts() {
    voxels_.resolution_m = kVoxel_m;
    OccupancyTree tree{kVoxel_m, {}};
    for (const auto& [code, log_odds] : log_odds_) {
      tree.leaves.push_back({VoxelCentre(KeyOfMortonCode(code), kVoxel_m), kVoxel_m, log_odds});
    }
    VoxelLabels none;  // labels of single voxels are not asked
    none.resolution_m = kVoxel_m;
    std::vector<std::size_t> sizes;
    for (const Cluster& part : SplitSteps(voxels_, {LeavesOfTree(tree), none}, shelf_)) {
      EXPECT_TRUE(std::ranges::is_sorted(part.voxels));
      sizes.push_back(part.voxels.size());
    }
    return sizes;
  }

  VoxelLabels voxels_;
  Cluster shelf_{1, {}, 0.8};

 private:
  std::map<std::uint64_t, float> log_odds_;
};

TEST_F(SplitStepsTest, ShelvesOfTwoHeightsAreTwo) {
  AddFront(0, 18, 18);
  AddFront(18, 38, 22);
  EXPECT_THAT(SizesOfParts(), testing::ElementsAre(18 * 18, 20 * 22));
}

TEST_F(SplitStepsTest, ARowOfThreeIsThree) {
  AddFront(0, 18, 18);
  AddFront(18, 38, 22);
  AddFront(38, 55, 30);
  EXPECT_THAT(SizesOfParts(), testing::UnorderedElementsAre(18 * 18, 20 * 22, 17 * 30));
}

TEST_F(SplitStepsTest, OneHeightIsOneThing) {
  AddFront(0, 18, 18);
  AddFront(18, 38, 19);  // noise
  EXPECT_EQ(SizesOfParts().size(), 1U);
}

TEST_F(SplitStepsTest, TheHeadOfABedIsTooShort) {
  AddFront(0, 30, 9);
  AddFront(30, 39, 17);
  EXPECT_EQ(SizesOfParts().size(), 1U);
}

TEST_F(SplitStepsTest, WhatNobodyLookedUpToIsNoTop) {
  AddFront(0, 18, 18, false);
  AddFront(18, 38, 30);
  EXPECT_EQ(SizesOfParts().size(), 1U);
}

}  // namespace nightmap::split_steps_test
