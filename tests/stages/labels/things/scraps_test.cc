// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/scraps.h"

#include <gtest/gtest.h>

#include <map>

namespace nightmap::scraps_test {

constexpr double kVoxel_m = 0.05;
constexpr std::uint8_t kFloor = 1, kSofa = 2, kTable = 3;

// Labelled voxels, of which those of a sofa are the cluster.
class StainsTest : public testing::Test {
 protected:
  void Fill(const VoxelKey& min, const VoxelKey& max, std::uint8_t label) {
    for (int x = min.x(); x < max.x(); ++x) {
      for (int y = min.y(); y < max.y(); ++y) {
        for (int z = min.z(); z < max.z(); ++z) labels_[MortonCode({x, y, z})] = label;
      }
    }
  }

  bool IsStainOfSofa() const {
    OccupancyTree tree{kVoxel_m, {}};
    VoxelLabels voxels;
    voxels.resolution_m = kVoxel_m;
    Cluster sofa{kSofa, {}, 1};
    for (const auto& [code, label] : labels_) {
      const VoxelKey key = KeyOfMortonCode(code);
      tree.leaves.push_back({VoxelCentre(key, kVoxel_m), kVoxel_m, 1.0F});
      if (label == kSofa) sofa.voxels.push_back(voxels.Size());
      voxels.keys.push_back(key);
      voxels.vote_labels.push_back(label);
      voxels.vote_weights.push_back(1);
      voxels.vote_offsets.push_back(voxels.vote_labels.size());
    }
    std::array<bool, 256> is_thing_class{};
    is_thing_class[kSofa] = is_thing_class[kTable] = true;
    return IsStain(voxels, LabelledSpace(LeavesOfTree(tree), voxels), is_thing_class, sofa);
  }

 private:
  std::map<std::uint64_t, std::uint8_t> labels_;
};

TEST_F(StainsTest, APartOfTheFloorIsOne) {
  Fill({-20, -20, 0}, {20, 20, 1}, kFloor);
  Fill({0, 0, 0}, {8, 8, 1}, kSofa);
  EXPECT_TRUE(IsStainOfSofa());
  Fill({2, 2, 1}, {5, 5, 2}, kSofa);  // noise of the depth
  EXPECT_TRUE(IsStainOfSofa());
}

TEST_F(StainsTest, WhatRisesAboveTheFloorIsNone) {
  Fill({-20, -20, 0}, {20, 20, 1}, kFloor);
  Fill({0, 0, 1}, {8, 8, 5}, kSofa);
  EXPECT_FALSE(IsStainOfSofa());
}

TEST_F(StainsTest, ASeatSeenFromAboveIsNone) {
  Fill({-20, -20, 0}, {20, 20, 1}, kFloor);
  Fill({0, 0, 9}, {8, 8, 10}, kSofa);
  EXPECT_FALSE(IsStainOfSofa());
}

TEST_F(StainsTest, WhatLiesOnATableIsNone) {
  Fill({-20, -20, 14}, {20, 20, 15}, kTable);
  Fill({0, 0, 14}, {8, 8, 16}, kSofa);
  EXPECT_FALSE(IsStainOfSofa());
}

VoxelLabels Column(int width, int height) {
  VoxelLabels voxels;
  voxels.resolution_m = kVoxel_m;
  for (int x = 0; x < width; ++x) {
    for (int z = 0; z < height; ++z) voxels.keys.push_back({x, 0, z});
  }
  return voxels;
}

bool IsLegOf(int width, int height) {
  const VoxelLabels voxels = Column(width, height);
  Cluster cluster{kTable, {}, 1};
  for (std::size_t i = 0; i < voxels.keys.size(); ++i) cluster.voxels.push_back(i);
  return IsLeg(voxels, cluster);
}

TEST(IsLeg, IsThinAndHigh) {
  EXPECT_TRUE(IsLegOf(1, 12));
  EXPECT_TRUE(IsLegOf(2, 12));
  EXPECT_FALSE(IsLegOf(2, 6));  // a bottle
  EXPECT_FALSE(IsLegOf(4, 20));
}

}  // namespace nightmap::scraps_test
