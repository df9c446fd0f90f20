// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/held_out_rays.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace nightmap::held_out_rays_test {

constexpr double kVoxel_m = 0.02;
constexpr double kTolerance_m = 0.03;
constexpr std::uint8_t kFold = 1, kOtherFold = 2;

// A square of a plane x = x_m that cameras at smaller x have measured.
void AddWall(double x_m, double half_edge_m, std::uint8_t folds, VoxelSums& cloud) {
  for (double y = -half_edge_m; y < half_edge_m; y += 0.5 * kVoxel_m) {
    for (double z = -half_edge_m; z < half_edge_m; z += 0.5 * kVoxel_m) {
      VoxelSum sum;
      sum.weight = 1;
      sum.weighted_position = {x_m, y, z};
      sum.direction = -Eigen::Vector3f::UnitX();
      sum.num_points = 1;
      sum.folds = folds;
      AddPoint(sum, kVoxel_m, cloud);
    }
  }
}

RayAgreement TestOne(const VoxelSums& cloud, const Eigen::Vector3d& end) {
  return AgreementOf(
      TestRays({{Eigen::Vector3d(-2, 0.1, 0.03), end, kTolerance_m, kFold}}, cloud, kVoxel_m, 1));
}

TEST(HeldOutRays, AgreeWhenTheyEndOnTheWall) {
  VoxelSums cloud;
  AddWall(1.003, 0.5, kOtherFold, cloud);
  for (int i = 0; i < 500; ++i) {
    Random random(6, static_cast<std::uint64_t>(i));
    const double off_m = random.Uniform(-0.9, 0.9) * kTolerance_m;
    const Eigen::Vector3d end(
        1.003 + off_m, random.Uniform(-0.45, 0.45), random.Uniform(-0.45, 0.45));
    EXPECT_EQ(TestOne(cloud, end).num_agreeing, 1U) << end.transpose();
  }
}

TEST(HeldOutRays, AreBlockedByWhatFloatsInFront) {
  VoxelSums cloud;
  AddWall(1.003, 0.5, kOtherFold, cloud);
  AddWall(0.3, 0.2, kOtherFold, cloud);
  const RayAgreement through = TestOne(cloud, {1.003, 0, 0});
  EXPECT_EQ(through.num_blocked, 1U);
  EXPECT_EQ(through.num_agreeing, 0U);
  EXPECT_EQ(TestOne(cloud, {1.003, 0.4, 0.4}).num_agreeing, 1U);  // beside it
}

TEST(HeldOutRays, ThatEndWhereNothingIsNeitherAgreeNorAreBlocked) {
  VoxelSums cloud;
  AddWall(1.003, 0.5, kOtherFold, cloud);
  for (const Eigen::Vector3d& end :
       {Eigen::Vector3d(0.5, 0, 0), Eigen::Vector3d(1.003, 0.8, 0), Eigen::Vector3d(0.94, 0, 0)}) {
    const RayAgreement result = TestOne(cloud, end);
    EXPECT_EQ(result.num_rays, 1U);
    EXPECT_EQ(result.num_agreeing + result.num_blocked, 0U) << end.transpose();
  }
}

TEST(HeldOutRays, DoNotSeeWhatTheirOwnFoldAloneHasMeasured) {
  VoxelSums cloud;
  AddWall(1.003, 0.5, kFold, cloud);
  EXPECT_EQ(TestOne(cloud, {1.003, 0, 0}).num_agreeing, 0U);
  EXPECT_EQ(TestOne(cloud, {1.5, 0, 0}).num_blocked, 0U);
  AddWall(1.003, 0.5, kOtherFold, cloud);  // both
  EXPECT_EQ(TestOne(cloud, {1.003, 0, 0}).num_agreeing, 1U);
  EXPECT_EQ(TestOne(cloud, {1.5, 0, 0}).num_blocked, 1U);
}

TEST(HeldOutRays, PassAlongAWallUnblocked) {
  VoxelSums cloud;
  AddWall(1.003, 0.5, kOtherFold, cloud);
  const HeldOutRay along{{1.0, -0.45, 0}, {1.003, 0.45, 0}, kTolerance_m, kFold};
  EXPECT_EQ(TestRays({along}, cloud, kVoxel_m, 1), std::vector{RayEnd::kOnTheCloud});
}

TEST(HeldOutRays, AreCountedTheSameByAnyNumberOfThreads) {
  VoxelSums cloud;
  AddWall(1.003, 0.5, kOtherFold, cloud);
  AddWall(0.3, 0.2, kOtherFold, cloud);
  std::vector<HeldOutRay> rays;
  for (int i = 0; i < 1000; ++i) {
    Random random(8, static_cast<std::uint64_t>(i));
    rays.push_back({{-2, 0, 0},
                    {1.003, random.Uniform(-0.7, 0.7), random.Uniform(-0.7, 0.7)},
                    kTolerance_m,
                    kFold});
  }
  const auto ends = TestRays(rays, cloud, kVoxel_m, 1);
  EXPECT_EQ(ends, TestRays(rays, cloud, kVoxel_m, 7));
  const RayAgreement one = AgreementOf(ends);
  EXPECT_EQ(one.num_rays, 1000U);
  EXPECT_GT(one.num_agreeing, 100U);
  EXPECT_GT(one.num_blocked, 30U);
  EXPECT_LT(one.num_agreeing + one.num_blocked, 1000U);
  EXPECT_TRUE(TestRays({}, cloud, kVoxel_m, 2).empty());
}

}  // namespace nightmap::held_out_rays_test
