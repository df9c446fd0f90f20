// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/drive.h"

#include "tests/laser_building.h"

namespace nightmap::drive_test {

struct Path {
  std::vector<Keyscan> keyscans;
  std::vector<SensorEdge> edges;

  Path() {
    Random random(1);
    Rigid2 pose{0.4, {1, 2}};
    for (int i = 0; i < 40; ++i) {
      keyscans.push_back({i, pose, 0, {}, {}});
      const Rigid2 next = pose * Rigid2{random.Uniform(-0.4, 0.6), {random.Uniform(0.1, 0.5), 0.1}};
      Eigen::Matrix2d root;
      for (double& value : root.reshaped()) value = 0.02 * random.Gaussian();
      Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
      covariance.topLeftCorner<2, 2>() = root * root.transpose();
      covariance(2, 2) = random.Uniform(1e-5, 4e-4);
      edges.push_back(
          {EdgeKind::kOdometry, i, i + 1, (next.Inverse() * pose).ToRigid3(), OnFloor(covariance)});
      pose = next;
    }
    edges.pop_back();
  }

  // The pose of keyscan b when keyscan a is where it is and edge `edge` is perturbed.
  Rigid2 PoseOf(std::size_t a, std::size_t b, std::size_t edge, const Rigid2& perturbation) const {
    Rigid2 pose = keyscans[a].start_from_robot;
    for (std::size_t i = a; i < b; ++i) {
      Rigid2 target_from_source = ToRigid2(edges[i].target_from_source);
      if (i == edge) target_from_source = perturbation * target_from_source;
      pose = pose * target_from_source.Inverse();
    }
    return pose;
  }
};

TEST(DriftSums, AddUpTheCovariancesOfAllEdgesBetween) {
  const Path path;
  const DriftSums drifts(path.keyscans, path.edges);
  constexpr double kStep = 1e-6;
  constexpr int kRows[] = {3, 4, 2};
  for (const auto& [a, b] :
       {std::pair<std::size_t, std::size_t>(0, 39), {0, 1}, {7, 30}, {38, 39}}) {
    Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
    for (std::size_t edge = a; edge < b; ++edge) {
      Eigen::Matrix3d jacobian;
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d delta = kStep * Eigen::Vector3d::Unit(i);
        const Rigid2 plus = path.PoseOf(a, b, edge, {delta[2], delta.head<2>()});
        const Rigid2 minus = path.PoseOf(a, b, edge, {-delta[2], -delta.head<2>()});
        jacobian.col(i) << (plus.translation - minus.translation) / (2 * kStep),
            WrapAngle_rad(plus.heading_rad - minus.heading_rad) / (2 * kStep);
      }
      Eigen::Matrix3d covariance;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          covariance(i, j) = path.edges[edge].covariance(kRows[i], kRows[j]);
        }
      }
      expected += jacobian * covariance * jacobian.transpose();
    }
    const Drift drift = drifts.Between(a, b);
    const Eigen::Matrix2d expected_m2 = expected.topLeftCorner<2, 2>();
    EXPECT_TRUE(drift.covariance_m2.isApprox(expected_m2, 1e-6)) << drift.covariance_m2 << "\n\n"
                                                                 << expected_m2;
    EXPECT_NEAR(drift.variance_rad2, expected(2, 2), 1e-9);
    EXPECT_NEAR(drift.Sigma_m(), std::sqrt(expected_m2.trace()), 1e-6);
    EXPECT_NEAR(drift.Sigma_rad(), std::sqrt(expected(2, 2)), 1e-6);
  }
}

TEST(DriftSums, NothingDriftsFromAKeyscanToItself) {
  const Path path;
  const Drift drift = DriftSums(path.keyscans, path.edges).Between(20, 20);
  EXPECT_LT(drift.covariance_m2.cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(drift.variance_rad2, 0);
}

// A night adds up more than a radian of motions that scans tell well.
TEST(DriftSums, ALongWayIsKnownHoweverMuchItAddsUp) {
  std::vector<Keyscan> keyscans;
  std::vector<SensorEdge> edges;
  for (int i = 0; i < 1000; ++i) {
    keyscans.push_back({i, Rigid2{0, {0.2 * i, 0}}, 0.2 * i, {}, {}});
    edges.push_back(
        {EdgeKind::kOdometry, i, i + 1, {}, OnFloor(0.004 * Eigen::Matrix3d::Identity())});
  }
  edges.pop_back();
  const Drift drift = DriftSums(keyscans, edges).Between(0, 999);
  EXPECT_GT(drift.Sigma_rad(), 1);
  EXPECT_FALSE(drift.IsUnknown());
  edges[400].covariance = 4 * Matrix6d::Identity();
  const DriftSums carried(keyscans, edges);
  EXPECT_TRUE(carried.Between(0, 999).IsUnknown());
  EXPECT_TRUE(carried.Between(400, 401).IsUnknown());
  EXPECT_FALSE(carried.Between(401, 999).IsUnknown());
  EXPECT_FALSE(carried.Between(0, 400).IsUnknown());
}

}  // namespace nightmap::drive_test
