// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/upright_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "pipeline/base/random.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap::upright_box_test {

constexpr double kResolution_m = 0.05;
constexpr double kRadPerDeg = std::numbers::pi / 180;

// Centres of the voxels that the surface of a cuboid crosses, seen faces only: +x, -x, +y, -y, top.
std::vector<Eigen::Vector3d> VoxelsOf(const Rigid2& map_from_box,
                                      const Eigen::Vector3d& size_m,
                                      const std::array<bool, 5>& faces) {
  std::set<std::uint64_t> voxels;
  const auto add = [&](const Eigen::Vector3d& share) {
    const Eigen::Vector3d point = share.cwiseProduct(size_m);
    const Eigen::Vector2d in_map = map_from_box * Eigen::Vector2d(point.head<2>());
    voxels.insert(PackVoxel(VoxelOf({in_map.x(), in_map.y(), point.z() + 0.4}, kResolution_m)));
  };
  constexpr int kSteps = 100;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const double a = 1.0 * i / kSteps - 0.5, b = 1.0 * j / kSteps;
      if (faces[0]) add({0.5, a, b});
      if (faces[1]) add({-0.5, a, b});
      if (faces[2]) add({a, 0.5, b});
      if (faces[3]) add({a, -0.5, b});
      if (faces[4]) add({a, b - 0.5, 1});
    }
  }
  std::vector<Eigen::Vector3d> centres;
  for (const std::uint64_t packed : voxels) {
    centres.push_back(VoxelCentre(UnpackVoxel(packed), kResolution_m));
  }
  return centres;
}

void ExpectBox(const UprightBox& box, const Rigid2& truth, const Eigen::Vector3d& size_m) {
  const double right_angle = std::numbers::pi / 2;
  EXPECT_GE(box.map_from_box.heading_rad, 0);
  EXPECT_LT(box.map_from_box.heading_rad, right_angle);
  const double turned =
      std::remainder(box.map_from_box.heading_rad - truth.heading_rad, right_angle);
  EXPECT_LT(std::abs(turned), 3 * kRadPerDeg);
  const double turns = (box.map_from_box.heading_rad - truth.heading_rad - turned) / right_angle;
  Eigen::Vector3d found_m = box.extent.sizes();
  if (std::lround(turns) % 2 != 0) std::swap(found_m.x(), found_m.y());
  EXPECT_LT((found_m - size_m).cwiseAbs().maxCoeff(), 1.01 * kResolution_m) << found_m.transpose();
  EXPECT_LT((box.Centre() - truth.translation).norm(), kResolution_m);
  EXPECT_NEAR(box.extent.min().z(), 0.4, kResolution_m);
}

class FitBoxTest : public testing::TestWithParam<int> {
 protected:
  Rigid2 truth_{GetParam() * kRadPerDeg, {3.21, -1.07}};
  Eigen::Vector3d size_m_{1.43, 0.77, 0.86};
};

TEST_P(FitBoxTest, ARotatedCuboidIsFound) {
  ExpectBox(FitBox(VoxelsOf(truth_, size_m_, {1, 1, 1, 1, 1}), kResolution_m), truth_, size_m_);
}

TEST_P(FitBoxTest, TheTopAloneWillDo) {
  std::vector<Eigen::Vector3d> points = VoxelsOf(truth_, size_m_, {0, 0, 0, 0, 1});
  const UprightBox box = FitBox(points, kResolution_m);
  EXPECT_NEAR(box.extent.sizes().z(), kResolution_m, 1e-9);
  const double turned = box.map_from_box.heading_rad - truth_.heading_rad;
  EXPECT_LT(std::abs(std::remainder(turned, std::numbers::pi / 2)), 3 * kRadPerDeg);
}

TEST_P(FitBoxTest, TwoFacesAloneWillDo) {
  ExpectBox(FitBox(VoxelsOf(truth_, size_m_, {1, 0, 0, 1, 0}), kResolution_m), truth_, size_m_);
}

TEST_P(FitBoxTest, AFewStraysDoNotTurnIt) {
  std::vector<Eigen::Vector3d> points = VoxelsOf(truth_, size_m_, {1, 1, 1, 1, 1});
  for (int i = 0; i < 8; ++i) {
    points.push_back(points.front() + Eigen::Vector3d(-0.05 * i - 0.3, 0.1, 0.2));
  }
  ExpectBox(FitBox(points, kResolution_m), truth_, size_m_);
}

INSTANTIATE_TEST_SUITE_P(Headings, FitBoxTest, testing::Values(0, 7, 20, 45, 63, 89, 131));

TEST(FitBox, OneVoxelIsABox) {
  const UprightBox box = FitBox({{1, 2, 3}}, kResolution_m);
  EXPECT_LT((box.extent.sizes() - Eigen::Vector3d::Constant(kResolution_m)).norm(), 1e-12);
  EXPECT_LT((box.Centre() - Eigen::Vector2d(1, 2)).norm(), 1e-12);
}

}  // namespace nightmap::upright_box_test
