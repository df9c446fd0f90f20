// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/ceiling_filter.h"

#include <Eigen/Eigenvalues>
#include <limits>

#include "pipeline/ceiling/planar_pose.h"
#include "tests/ceiling/numeric_derivative.h"
#include "tests/test_data.h"

namespace nightmap::ceiling_filter_test {

UpwardCamera MakeCamera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 320;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return {camera, {Eigen::Quaterniond::Identity(), {0, 0, 0.35}}};
}

// Only what is wrong all the time is unknown.
CeilingNoise Biases() {
  CeilingNoise noise;
  noise.distance_sigma_m = noise.heading_sigma_rad = noise.turn_sigma_rad = 1e-6;
  noise.vibration_sigma_rad = noise.mounting_tilt_sigma_rad = 0;
  noise.scale_sigma = 0.02;
  noise.heading_bias_sigma_rad_per_m = 0.01;
  return noise;
}

ControlInput Motion(double distance_m, double turn_rad) {
  return {{turn_rad, {distance_m, 0.1 * distance_m}}, distance_m, std::abs(turn_rad), 0};
}

std::vector<ControlInput> MakeDrive() {
  std::vector<ControlInput> drive;
  for (int i = 0; i < 20; ++i) drive.push_back(Motion(0.1, i < 10 ? 0.05 : -0.11));
  return drive;
}

// x, y, heading after a drive with these errors of scale and heading.
Eigen::VectorXd PoseAfter(const std::vector<ControlInput>& drive, const Eigen::VectorXd& errors) {
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  for (const ControlInput& input : drive) {
    const double made_up_rad = errors[1] * input.distance_m;
    const Eigen::Vector2d way = (1 + errors[0]) * input.before_from_after.translation;
    pose.head<2>() += Eigen::Rotation2Dd(pose.z() + made_up_rad / 2) * way;
    pose.z() += input.before_from_after.heading_rad + made_up_rad;
  }
  return pose;
}

TEST(CeilingFilter, PredictionsHaveTheCovarianceOfNumericDerivatives) {
  const std::vector<ControlInput> drive = MakeDrive();
  for (const bool moves_anchor : {false, true}) {
    CeilingFilter filter(MakeCamera(), Biases());
    for (std::size_t i = 0; i < drive.size(); ++i) {
      filter.Predict(drive[i]);
      if (moves_anchor && i % 7 == 6) filter.MoveAnchor();
    }
    const Eigen::Vector2d none = Eigen::Vector2d::Zero();
    EXPECT_LT((ToVector(filter.MapFromRobot()) - PoseAfter(drive, none)).norm(), 1e-9);
    const Eigen::MatrixXd by_errors = NumericDerivative(
        [&](const Eigen::VectorXd& errors) { return PoseAfter(drive, errors); }, none);
    const Eigen::Vector2d variance(0.02 * 0.02, 0.01 * 0.01);
    const Eigen::Matrix3d expected = by_errors * variance.asDiagonal() * by_errors.transpose();
    EXPECT_LT((filter.RobotCovariance() - expected).norm(), 2e-3 * expected.norm()) << moves_anchor;
  }
}

// The robot's way between two anchors, by the filter's correlations: that of a drive from there.
TEST(CeilingFilter, AnchorsAreAsFarApartAsTheWayBetweenThemIsUncertain) {
  const std::vector<ControlInput> drive = MakeDrive();
  CeilingFilter filter(MakeCamera(), Biases());
  for (const ControlInput& input : drive) filter.Predict(input);
  filter.MoveAnchor();
  for (const ControlInput& input : drive) filter.Predict(input);
  filter.MoveAnchor();
  EXPECT_EQ(filter.NumAnchors(), 3);
  // last_from_anchor is the inverse of the drive.
  const Eigen::Vector2d none = Eigen::Vector2d::Zero();
  const Eigen::MatrixXd by_errors = NumericDerivative(
      [&](const Eigen::VectorXd& errors) -> Eigen::VectorXd {
        return Between(PoseAfter(drive, errors), Eigen::Vector3d::Zero()).pose;
      },
      none);
  const Eigen::Vector2d variance(0.02 * 0.02, 0.01 * 0.01);
  const Eigen::Matrix3d expected = by_errors * variance.asDiagonal() * by_errors.transpose();
  EXPECT_LT((filter.RelativeCovariance(1) - expected).norm(), 2e-3 * expected.norm());
}

TEST(CeilingFilter, ALoopMovesAllAnchorsAndTheRobot) {
  CeilingNoise noise = Biases();
  noise.heading_sigma_rad = 0.05;
  CeilingFilter filter(MakeCamera(), noise);
  for (int anchor = 0; anchor < 4; ++anchor) {
    for (int i = 0; i < 10; ++i) filter.Predict(Motion(0.1, 0));
    filter.MoveAnchor();
  }
  const Eigen::Matrix3d before = filter.RelativeCovariance(0);
  const Rigid2 expected = filter.MapFromAnchor(4).Inverse() * filter.MapFromAnchor(0);
  const Rigid2 measured{expected.heading_rad + 0.05, expected.translation};
  const Eigen::Matrix3d covariance = 1e-8 * Eigen::Matrix3d::Identity();
  const double middle_rad = filter.MapFromAnchor(2).heading_rad;
  filter.CloseLoop(0, measured, covariance);
  const Rigid2 after = filter.MapFromAnchor(4).Inverse() * filter.MapFromAnchor(0);
  EXPECT_NEAR(after.heading_rad, measured.heading_rad, 1e-3);
  EXPECT_LT((after.translation - measured.translation).norm(), 0.02);
  EXPECT_LT(filter.RelativeCovariance(0).trace(), 1e-3 * before.trace());
  // Anchors between move along, and nothing that is known for sure: the first anchor.
  EXPECT_GT(std::abs(filter.MapFromAnchor(2).heading_rad - middle_rad), 0.005);
  EXPECT_LT(filter.MapFromAnchor(0).translation.norm(), 1e-3);
}

TEST(CeilingFilter, ALandmarkIsWhereTwoViewsMeet) {
  CeilingNoise noise;
  CeilingFilter filter(MakeCamera(), noise);
  const Eigen::Vector3d point(0.5, 0.3, 2.6);
  const auto seen = [&] {
    return MakeCamera().Project(ToVector(filter.AnchorFromRobot()), {0, 0}, point)->pixel;
  };
  const std::int64_t clone = filter.AddClone();
  const Eigen::Vector2d from = seen();
  constexpr double kGate = 18;
  EXPECT_FALSE(filter.AddLandmark(5, clone, from, seen(), 0.1, kGate));  // no way between
  for (int i = 0; i < 6; ++i) filter.Predict(Motion(0.1, 0.02));
  const Eigen::Vector2d now = seen();
  // A corner that is another one than that of the first view.
  EXPECT_FALSE(filter.AddLandmark(5, clone, from, now + Eigen::Vector2d(0, 60), 0.1, kGate));
  EXPECT_TRUE(filter.Landmarks().empty());
  ASSERT_TRUE(filter.AddLandmark(5, clone, from, now, 0.1, kGate));
  ASSERT_EQ(filter.Landmarks().size(), 1U);
  EXPECT_LT((filter.Landmarks()[0].position - point).norm(), 1e-3);
  EXPECT_LT(filter.Landmarks()[0].covariance.trace(), 0.1);
  EXPECT_LT(filter.Gates({{5, now}})[0], 1e-3);
  EXPECT_GT(filter.Gates({{5, now + Eigen::Vector2d(30, 0)}})[0], 100);
  EXPECT_EQ(filter.Gates({{6, now}})[0], std::numeric_limits<double>::infinity());
  filter.MoveAnchor();
  EXPECT_LT(filter.Gates({{5, now}})[0], 1e-3);
  filter.RemoveClones({clone});
  EXPECT_LT(filter.Gates({{5, now}})[0], 1e-3);
  filter.RemoveLandmarks({5});
  EXPECT_TRUE(filter.Landmarks().empty());
}

TEST(CeilingFilter, APublishedLandmarkHasTheDepthOfItsDisparity) {
  CeilingFilter filter(MakeCamera(), {});
  const Eigen::Vector3d point(0.5, 0.3, 2.6);
  const auto seen = [&] {
    return MakeCamera().Project(ToVector(filter.AnchorFromRobot()), {0, 0}, point)->pixel;
  };
  const std::int64_t clone = filter.AddClone();
  const Eigen::Vector2d from = seen();
  EXPECT_FALSE(filter.AddLandmarkByDisparity(5, clone, from, seen()));  // no way between
  filter.Predict(Motion(0, 0.3));
  EXPECT_FALSE(filter.AddLandmarkByDisparity(5, clone, from, seen()));  // a turn on the spot
  filter.Predict(Motion(0.02, 0));
  EXPECT_FALSE(filter.AddLandmarkByDisparity(5, clone, from, seen()));  // 3 pixels: noise
  filter.Predict(Motion(0.08, 0.02));
  const Eigen::Vector2d now = seen();
  EXPECT_TRUE(filter.Landmarks().empty());
  ASSERT_TRUE(filter.AddLandmarkByDisparity(5, clone, from, now));
  ASSERT_EQ(filter.Landmarks().size(), 1U);
  const ActiveLandmark landmark = filter.Landmarks()[0];
  EXPECT_LT((landmark.position - point).norm(), 1e-9);
  // Z = f T / (x1 - x2): the wheels tell a way of 0.1 m, and the disparity is 14 pixels, of which
  // each picture tells 0.4 and its tilt 1 more.
  const double of_way = CeilingNoise().distance_sigma_m / std::sqrt(0.1);
  const double expected = std::hypot(of_way, std::sqrt(2 * 1.1) / 14.3);
  EXPECT_NEAR(std::sqrt(landmark.covariance(2, 2)) / 2.25, expected, 0.1 * expected);
  EXPECT_LT(filter.Gates({{5, now}})[0], 1e-3);
  filter.RemoveLandmarks({5});
  EXPECT_TRUE(filter.Landmarks().empty());
}

TEST(CeilingFilter, WithoutOdometryTheRobotMayBeAsFarAsItsSpeedAllows) {
  CeilingNoise noise;
  noise.unknown_speed_m_per_s = 0.5;
  for (const int num_frames : {20, 60}) {
    CeilingFilter filter(MakeCamera(), noise);
    for (int i = 0; i < num_frames; ++i) filter.Predict({{}, 0, 0, 2.0 / num_frames});
    EXPECT_NEAR(std::sqrt(filter.RobotCovariance()(0, 0)), 0.5 * 2, 0.05);
  }
}

}  // namespace nightmap::ceiling_filter_test
