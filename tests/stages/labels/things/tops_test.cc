// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/tops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace nightmap::tops_test {

constexpr double kVoxel_m = 0.05;
constexpr std::uint8_t kTable = 1, kShelf = 2;
constexpr int kTopLayer = 14;

// Blocks of labelled voxels, each of which is a cluster, and space that was seen free.
class TopsTest : public testing::Test {
 protected:
  void AddFree(const VoxelKey& min, const VoxelKey& max) { Fill(min, max, -1); }

  // Returns the index of the new cluster.
  std::size_t AddThing(std::uint8_t label, const VoxelKey& min, const VoxelKey& max) {
    clusters_.push_back({label, {}, 1});
    AddTo(clusters_.size() - 1, min, max);
    return clusters_.size() - 1;
  }

  void AddTo(std::size_t cluster, const VoxelKey& min, const VoxelKey& max) {
    for (const VoxelKey& key : Fill(min, max, 1)) {
      clusters_[cluster].voxels.push_back(voxels_.Size());
      voxels_.keys.push_back(key);
      voxels_.vote_labels.push_back(clusters_[cluster].label);
      voxels_.vote_weights.push_back(1);
      voxels_.vote_offsets.push_back(voxels_.vote_labels.size());
    }
  }

  std::vector<Cluster> Join(double max_hidden_m = 0.6) {
    voxels_.resolution_m = kVoxel_m;
    OccupancyTree tree{kVoxel_m, {}};
    for (const auto& [code, log_odds] : log_odds_) {
      tree.leaves.push_back({VoxelCentre(KeyOfMortonCode(code), kVoxel_m), kVoxel_m, log_odds});
    }
    VoxelLabels none;  // labels of single voxels are not asked
    none.resolution_m = kVoxel_m;
    return JoinTops(voxels_, LabelledSpace(LeavesOfTree(tree), none), max_hidden_m, clusters_);
  }

  std::optional<int> TopOf(std::size_t cluster) const {
    return TopLayer(voxels_, clusters_[cluster], kTopShare);
  }

  VoxelLabels voxels_;
  std::vector<Cluster> clusters_;

 private:
  std::vector<VoxelKey> Fill(const VoxelKey& min, const VoxelKey& max, float log_odds) {
    std::vector<VoxelKey> keys;
    for (int x = min.x(); x < max.x(); ++x) {
      for (int y = min.y(); y < max.y(); ++y) {
        for (int z = min.z(); z < max.z(); ++z) {
          keys.emplace_back(x, y, z);
          log_odds_[MortonCode(keys.back())] = log_odds;
        }
      }
    }
    return keys;
  }

  std::map<std::uint64_t, float> log_odds_;
};

TEST_F(TopsTest, ATableHasATopWithItsLegsAndAShelfAndAChairHaveNone) {
  const std::size_t table = AddThing(kTable, {0, 0, kTopLayer}, {20, 12, kTopLayer + 1});
  AddTo(table, {0, 0, 0}, {1, 1, kTopLayer});
  AddTo(table, {19, 0, 0}, {20, 1, kTopLayer});
  EXPECT_EQ(TopOf(table), kTopLayer);
  EXPECT_EQ(TopOf(AddThing(kShelf, {0, 0, 0}, {20, 1, 20})), std::nullopt);
  const std::size_t chair = AddThing(kTable, {0, 0, 9}, {9, 9, 10});
  AddTo(chair, {0, 0, 10}, {9, 1, 18});  // its back is above the seat
  EXPECT_EQ(TopOf(chair), std::nullopt);
}

// Both ends of a table of 1.2 m; what is between them was not seen.
class EndsOfATable : public TopsTest {
 protected:
  void SetUp() override {
    AddThing(kTable, {0, 0, kTopLayer}, {8, 12, kTopLayer + 1});
    AddThing(kTable, {16, 0, kTopLayer}, {24, 12, kTopLayer + 1});
  }
};

TEST_F(EndsOfATable, AreJoinedWhereHidden) {
  const auto joined = Join();
  ASSERT_EQ(joined.size(), 1U);
  EXPECT_EQ(joined[0].voxels.size(), 2U * 8 * 12);
}

TEST_F(EndsOfATable, StayApartWhereFreeSpaceIsSeenBetween) {
  AddFree({8, 0, kTopLayer}, {16, 12, kTopLayer + 1});
  EXPECT_EQ(Join().size(), 2U);
}

TEST_F(EndsOfATable, FreeSpaceBelowTheTopIsThatUnderATable) {
  AddFree({8, 0, 0}, {16, 12, kTopLayer});
  EXPECT_EQ(Join().size(), 1U);
}

TEST_F(EndsOfATable, StayApartWhenTheyAreFar) { EXPECT_EQ(Join(0.3).size(), 2U); }

TEST_F(TopsTest, OtherHeightsAndOtherClassesStayApart) {
  AddThing(kTable, {0, 0, kTopLayer}, {8, 12, kTopLayer + 1});
  AddThing(kTable, {9, 0, kTopLayer + 3}, {17, 12, kTopLayer + 4});
  AddThing(kShelf, {9, 20, kTopLayer}, {17, 32, kTopLayer + 1});
  EXPECT_EQ(Join().size(), 3U);
}

TEST_F(TopsTest, AMiddlePartJoinsBothEnds) {
  AddThing(kTable, {0, 0, kTopLayer}, {6, 12, kTopLayer + 1});
  AddThing(kTable, {30, 0, kTopLayer}, {36, 12, kTopLayer + 1});
  AddThing(kTable, {15, 0, kTopLayer}, {21, 12, kTopLayer + 1});
  const auto joined = Join();
  ASSERT_EQ(joined.size(), 1U);
  EXPECT_TRUE(std::ranges::is_sorted(joined[0].voxels));
}

}  // namespace nightmap::tops_test
