// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/join_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nightmap::join_parts_test {

// One voxel of 5 cm per key, and clusters of consecutive ones.
VoxelLabels RowOf(int count) {
  VoxelLabels voxels;
  voxels.resolution_m = 0.05;
  for (int i = 0; i < count; ++i) voxels.keys.push_back({i, 0, 0});
  return voxels;
}

Cluster Voxels(std::uint8_t label, std::size_t begin, std::size_t end, double share) {
  Cluster cluster{label, {}, share};
  for (std::size_t i = begin; i < end; ++i) cluster.voxels.push_back(i);
  return cluster;
}

UprightBox BoxTo(double max_x_m) {
  return {{}, {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(max_x_m, 0.05, 0.05)}};
}

TEST(JoinParts, APartInTheBoxOfALargerOneIsJoined) {
  const VoxelLabels voxels = RowOf(20);
  const std::vector<Cluster> clusters = {Voxels(1, 0, 2, 0.6), Voxels(1, 4, 10, 1)};
  const auto joined = JoinParts(voxels, clusters, {BoxTo(0.1), BoxTo(0.5)});
  ASSERT_EQ(joined.size(), 1U);
  EXPECT_THAT(joined[0].voxels, testing::ElementsAre(0, 1, 4, 5, 6, 7, 8, 9));
  EXPECT_NEAR(joined[0].mean_share, (2 * 0.6 + 6) / 8, 1e-12);
}

TEST(JoinParts, OtherClassesAndOtherPlacesStayApart) {
  const VoxelLabels voxels = RowOf(20);
  EXPECT_EQ(
      JoinParts(voxels, {Voxels(1, 4, 10, 1), Voxels(2, 0, 2, 1)}, {BoxTo(0.5), BoxTo(0.1)}).size(),
      2U);
  UprightBox behind = BoxTo(0.9);
  behind.extent.min().x() = 0.45;
  const auto apart =
      JoinParts(voxels, {Voxels(1, 0, 6, 1), Voxels(1, 8, 18, 1)}, {BoxTo(0.3), behind});
  ASSERT_EQ(apart.size(), 2U);
  EXPECT_EQ(apart[0].voxels.front(), 0U);  // in order of first voxel, not of size
}

}  // namespace nightmap::join_parts_test
