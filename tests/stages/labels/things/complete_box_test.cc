// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/complete_box.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>

namespace nightmap::complete_box_test {

constexpr double kVoxel_m = 0.05;
constexpr std::uint8_t kSofa = 0, kTable = 1, kWall = 2;

// Only the front of a thing is known, a face of 20 x 20 voxels that looks along -x, and the free
// space before it, beside it and above it.
class CompleteBoxTest : public testing::Test {
 protected:
  static constexpr int kSize = 20;

  CompleteBoxTest() {
    Fill({-10, -20, 0}, {0, 40, 40}, std::nullopt);
    Fill({0, -20, 0}, {20, 0, 40}, std::nullopt);
    Fill({0, kSize, 0}, {20, 40, 40}, std::nullopt);
    Fill({0, -20, kSize}, {20, 40, 40}, std::nullopt);
    Fill({0, 0, 0}, {1, kSize, kSize}, kSofa);
  }

  // No label: free.
  void Fill(const VoxelKey& min, const VoxelKey& max, std::optional<std::uint8_t> label) {
    for (VoxelKey key = min; key.z() < max.z(); ++key.z()) {
      for (key.y() = min.y(); key.y() < max.y(); ++key.y()) {
        for (key.x() = min.x(); key.x() < max.x(); ++key.x()) voxels_[MortonCode(key)] = label;
      }
    }
  }

  UprightBox Complete(double max_hidden_m = 0.6, std::optional<int> top_layer = {}) const {
    OccupancyTree tree{kVoxel_m, {}};
    VoxelLabels labels;
    labels.resolution_m = kVoxel_m;
    std::vector<Eigen::Vector3d> points;
    for (const auto& [code, label] : voxels_) {
      const VoxelKey key = KeyOfMortonCode(code);
      const Eigen::Vector3d centre = VoxelCentre(key, kVoxel_m);
      tree.leaves.push_back({centre, kVoxel_m, label ? 1.0F : -1.0F});
      if (!label) continue;
      labels.keys.push_back(key);
      labels.vote_labels.push_back(*label);
      labels.vote_weights.push_back(1);
      labels.vote_offsets.push_back(labels.vote_labels.size());
      if (*label == kSofa) points.push_back(centre);
    }
    CompletionOptions options{.label = kSofa, .max_hidden_m = max_hidden_m, .top_layer = top_layer};
    options.is_thing_class[kSofa] = options.is_thing_class[kTable] = true;
    UprightBox box{{}, {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(kVoxel_m, 1, 1)}};
    CompleteBox(options, LabelledSpace(LeavesOfTree(tree), labels), points, &box);
    return box;
  }

  std::map<std::uint64_t, std::optional<std::uint8_t>> voxels_;
};

TEST_F(CompleteBoxTest, ReachesTheWallBesideAndAboveIt) {
  Fill({9, -20, 0}, {10, 0, 40}, kWall);
  EXPECT_NEAR(Complete().extent.max().x(), 9 * kVoxel_m, kVoxel_m);
  Fill({9, -20, 0}, {10, 0, 40}, std::nullopt);
  Fill({7, 0, kSize}, {8, kSize, 40}, kWall);
  EXPECT_NEAR(Complete().extent.max().x(), 7 * kVoxel_m, kVoxel_m);
  EXPECT_NEAR(Complete(0.2).extent.max().x(), kVoxel_m + 0.1, 1e-9);  // not so far
}

TEST_F(CompleteBoxTest, OtherSidesStay) {
  Fill({9, -20, 0}, {10, 0, 40}, kWall);
  const Eigen::AlignedBox3d extent = Complete().extent;
  EXPECT_EQ(extent.min().x(), 0);
  EXPECT_EQ(extent.min().y(), 0);
  EXPECT_EQ(extent.max().y(), 1);
  EXPECT_EQ(extent.max().z(), 1);
}

TEST_F(CompleteBoxTest, FreeSpaceBehindKeepsTheBack) {
  Fill({1, 0, 0}, {20, kSize, kSize}, std::nullopt);
  EXPECT_EQ(Complete().extent.max().x(), kVoxel_m);
}

TEST_F(CompleteBoxTest, EndsHalfwayWhereNothingTellsTheEnd) {
  EXPECT_NEAR(Complete().extent.max().x(), kVoxel_m + 0.3, 1e-9);
  Fill({9, 0, 0}, {20, kSize, kSize}, std::nullopt);  // seen from behind
  EXPECT_NEAR(Complete().extent.max().x(), kVoxel_m + 0.2, 0.5 * kVoxel_m + 1e-9);
  EXPECT_EQ(Complete(0).extent.max().x(), kVoxel_m);
}

TEST_F(CompleteBoxTest, EndsAtAnotherThing) {
  Fill({5, 0, 0}, {6, kSize, kSize}, kTable);
  EXPECT_NEAR(Complete().extent.max().x(), 5 * kVoxel_m, kVoxel_m);
}

TEST_F(CompleteBoxTest, AWallAcrossEndsNothing) {
  Fill({0, -3, 0}, {20, -2, 40}, kWall);
  EXPECT_NEAR(Complete().extent.max().x(), kVoxel_m + 0.3, 1e-9);
}

// The front edge of a table's top, with a chair before it and the floor around.
TEST_F(CompleteBoxTest, ATopOnLegsIsLoweredAndOtherThingsHideIt) {
  voxels_.clear();
  Fill({-20, -20, 0}, {30, 40, 1}, kWall);
  Fill({-10, -10, 1}, {12, 30, 19}, std::nullopt);  // seen free, under the table too
  Fill({0, 0, 19}, {1, kSize, 20}, kSofa);
  Fill({1, 4, 10}, {3, 8, 24}, kTable);
  Fill({9, -20, 1}, {10, 40, 30}, kWall);
  const Eigen::AlignedBox3d extent = Complete(0.6, 19).extent;
  EXPECT_NEAR(extent.min().z(), 0, 2 * kVoxel_m);
  EXPECT_NEAR(extent.max().x(), 9 * kVoxel_m, kVoxel_m);
}

}  // namespace nightmap::complete_box_test
