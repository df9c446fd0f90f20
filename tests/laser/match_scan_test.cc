// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/match_scan.h"

#include <ceres/cubic_interpolation.h>
#include <ceres/jet.h>

#include <cmath>
#include <numbers>

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::match_scan_test {

const LikelihoodFieldOptions kField{.resolution_m = 0.05, .half_extent_m = 8, .sigma_m = 0.08};
constexpr int kNumLevels = 4;

// The walls of a room with a niche, 5 cm apart.
std::vector<Eigen::Vector2d> Room() {
  std::vector<Eigen::Vector2d> points;
  for (double s = 0; s < 6; s += 0.05) {
    points.push_back({s - 3, -2});
    points.push_back({s - 3, s > 2 && s < 3 ? 2.5 : 2});
    if (s < 4) points.push_back({-3, s - 2});
    if (s < 4) points.push_back({3, s - 2});
  }
  return points;
}

std::vector<Eigen::Vector2d> SeenFrom(const Rigid2& field_from_robot,
                                      const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector2d> seen;
  for (const Eigen::Vector2d& point : points) seen.push_back(field_from_robot.Inverse() * point);
  return seen;
}

Rigid2 RandomPose(Random& random, double shift_m, double turn_rad) {
  return {random.Uniform(-turn_rad, turn_rad),
          {random.Uniform(-shift_m, shift_m), random.Uniform(-shift_m, shift_m)}};
}

TEST(MatchScan, FindsThePoseInARoomToAFractionOfACell) {
  LikelihoodField field(kField);
  field.Add(Room());
  Random random(5);
  for (int round = 0; round < 20; ++round) {
    const Rigid2 truth = RandomPose(random, 0.5, 0.4);
    const auto points = SeenFrom(truth, Room());
    PosePrior prior{truth, 0.1, 0.05};
    prior.field_from_robot.translation += Eigen::Vector2d(0.15, -0.1);
    prior.field_from_robot.heading_rad += 0.08;
    const ScanMatch match = MatchScan(FieldPyramid(field, kNumLevels), points, prior);
    EXPECT_LT((match.field_from_robot.translation - truth.translation).norm(), 0.01);
    EXPECT_NEAR(match.field_from_robot.heading_rad, truth.heading_rad, 0.004);
    EXPECT_GT(match.score, 0.9);
    EXPECT_LT(match.covariance(0, 0), 1e-3);
  }
}

// Two walls along x say nothing of x.
TEST(MatchScan, TheCovarianceOfACorridorIsThatOfThePriorAlongIt) {
  std::vector<Eigen::Vector2d> corridor;
  for (double x = -7; x < 7; x += 0.05) {
    corridor.push_back({x, 1});
    corridor.push_back({x, -1});
  }
  LikelihoodField field(kField);
  field.Add(corridor);
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& point : corridor) {
    if (std::abs(point.x()) < 4) points.push_back(point);
  }
  const ScanMatch match =
      MatchScan(FieldPyramid(field, kNumLevels), points, {{0, {0.02, 0.03}}, 0.1, 0.05});
  EXPECT_NEAR(std::sqrt(match.covariance(0, 0)), 0.1, 0.02);
  EXPECT_LT(std::sqrt(match.covariance(1, 1)), 0.03);
  EXPECT_NEAR(match.field_from_robot.translation.x(), 0.02, 0.02);
  EXPECT_NEAR(match.field_from_robot.translation.y(), 0, 0.01);
}

// Seven metres of two walls were seen, and the scan sees two metres more of them ahead.
struct BareCorridor {
  LikelihoodField field{kField};
  std::vector<Eigen::Vector2d> points;
  Constraints walls;
  PosePrior prior{{0, {0, 0}}, 0.1, 0.05};

  BareCorridor() {
    std::vector<Eigen::Vector2d> seen;
    for (double x = -5; x < 2; x += 0.05) {
      for (const double y : {-1, 1}) {
        seen.emplace_back(x, y);
        if (x + 2 > -3) points.emplace_back(x + 2, y);
      }
    }
    field.Add(seen);
    walls.normals_in_robot.assign(points.size(), Eigen::Vector2d::UnitY());
  }
};

TEST(MatchScan, TheEndOfWhatWasSeenOfAWallDoesNotHoldAScan) {
  const BareCorridor corridor;
  const auto x_m = [&](const Constraints& constraints) {
    const Rigid2& start = corridor.prior.field_from_robot;
    return RefinePose(corridor.field, corridor.points, corridor.prior, start, constraints)
        .field_from_robot.translation.x();
  };
  EXPECT_LT(x_m({}), -0.02);
  EXPECT_NEAR(x_m(corridor.walls), 0, 0.002);
}

TEST(MatchScan, TheAxisOfABareCorridorIsUnclear) {
  const BareCorridor corridor;
  const auto along =
      UnclearDirection(corridor.field, corridor.points, corridor.walls.normals_in_robot, Rigid2{});
  ASSERT_TRUE(along.has_value());
  EXPECT_GT(std::abs(along->x()), 0.999);
}

TEST(MatchScan, InARoomNothingIsUnclear) {
  LikelihoodField field(kField);
  field.Add(Room());
  std::vector<Eigen::Vector2d> normals;
  for (const Eigen::Vector2d& point : Room()) {
    normals.push_back(std::abs(point.y()) >= 2 ? Eigen::Vector2d::UnitY()
                                               : Eigen::Vector2d::UnitX());
  }
  EXPECT_FALSE(UnclearDirection(field, Room(), normals, Rigid2{}).has_value());
}

TEST(MatchScan, AHeldPoseKeepsItsPlaceAlongTheDirection) {
  LikelihoodField field(kField);
  field.Add(Room());
  const Rigid2 start{0, {0.06, 0.06}};
  const ScanMatch match =
      RefinePose(field, Room(), {start, 0.1, 0.05}, start, {{}, Eigen::Vector2d::UnitX()});
  EXPECT_NEAR(match.field_from_robot.translation.x(), 0.06, 0.003);
  EXPECT_NEAR(match.field_from_robot.translation.y(), 0, 0.01);
}

// The robot looks across the corridor: what is not known is to its left and right.
TEST(MatchScan, TheCovarianceInTheRobotTurnsWithIt) {
  ScanMatch match{{std::numbers::pi / 2, {3, 4}}, 1, {}};
  match.covariance.diagonal() << 0.04, 0.0001, 0.0009;
  match.covariance(0, 2) = match.covariance(2, 0) = 0.002;
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  expected.diagonal() << 0.0001, 0.04, 0.0009;
  expected(1, 2) = expected(2, 1) = -0.002;
  EXPECT_LT((CovarianceInRobot(match) - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(MatchScan, WithoutPointsThePriorStays) {
  const LikelihoodField field(kField);
  const ScanMatch match =
      MatchScan(FieldPyramid(field, kNumLevels), {}, {{0.2, {1, 2}}, 0.1, 0.05});
  EXPECT_NEAR(match.field_from_robot.translation.x(), 1, 1e-9);
  EXPECT_NEAR(match.field_from_robot.heading_rad, 0.2, 1e-9);
  EXPECT_EQ(match.score, 0);
  EXPECT_NEAR(match.covariance(0, 0), 0.01, 1e-9);
}

// The sum that RefinePose makes small: 1 - field over all points, and half the squares of the
// prior's errors; by the interpolation of the field.
template <typename T>
T SurpriseAt(const LikelihoodField& field,
             const std::vector<Eigen::Vector2d>& points,
             const PosePrior& prior,
             const Eigen::Matrix<T, 3, 1>& pose) {
  const ceres::BiCubicInterpolator<LikelihoodField> interpolator(field);
  const Eigen::Rotation2D<T> turn(pose[2]);
  const Eigen::Matrix<T, 2, 1> shift = pose.template head<2>();
  const Eigen::Vector2d origin = field.ToCells({0, 0});
  T sum(0);
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Matrix<T, 2, 1> cell =
        (turn * point.cast<T>() + shift) / T(field.Resolution_m()) + origin.cast<T>();
    T value;
    interpolator.Evaluate(cell.y(), cell.x(), &value);
    if (value < 1.0) sum += 1.0 - value;  // the interpolation overshoots
  }
  const Eigen::Matrix<T, 2, 1> off = (shift - prior.field_from_robot.translation) / prior.sigma_m;
  const T turned = (pose[2] - prior.field_from_robot.heading_rad) / prior.sigma_rad;
  return sum + 0.5 * (off.squaredNorm() + turned * turned);
}

Eigen::Vector3d VectorOf(const Rigid2& pose) {
  return {pose.translation.x(), pose.translation.y(), pose.heading_rad};
}

// By Ceres' derivatives of the interpolation.
Eigen::Vector3d GradientAt(const LikelihoodField& field,
                           const std::vector<Eigen::Vector2d>& points,
                           const PosePrior& prior,
                           const Eigen::Vector3d& pose) {
  using Jet = ceres::Jet<double, 3>;
  const Eigen::Matrix<Jet, 3, 1> jets(Jet(pose[0], 0), Jet(pose[1], 1), Jet(pose[2], 2));
  return SurpriseAt<Jet>(field, points, prior, jets).v;
}

TEST(MatchScan, DerivativesOfTheScoreAreThoseOfSmallSteps) {
  LikelihoodField field(kField);
  field.Add(Room());
  Random random(6);
  constexpr double kStep = 1e-6;
  for (int round = 0; round < 50; ++round) {
    const PosePrior prior{RandomPose(random, 0.2, 0.1), 0.1, 0.05};
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 40; ++i) points.push_back({random.Uniform(-9, 9), random.Uniform(-9, 9)});
    const Eigen::Vector3d pose = VectorOf(RandomPose(random, 0.3, 0.2));
    const Eigen::Vector3d gradient = GradientAt(field, points, prior, pose);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const double difference = SurpriseAt<double>(field, points, prior, pose + step) -
                                SurpriseAt<double>(field, points, prior, pose - step);
      EXPECT_NEAR(gradient[i], difference / (2 * kStep), 1e-3) << round << " " << i;
    }
  }
}

// Few points do not lie on the cells' centres, where the interpolation has its kinks.
TEST(RefinePose, EndsWhereTheScoreAndThePriorDoNotChange) {
  LikelihoodField field(kField);
  field.Add(Room());
  Random random(7);
  for (int round = 0; round < 20; ++round) {
    const Rigid2 truth = RandomPose(random, 0.5, 0.4);
    std::vector<Eigen::Vector2d> points = SeenFrom(truth, Room());
    for (Eigen::Vector2d& point : points) {
      point += 0.03 * Eigen::Vector2d(random.Gaussian(), random.Gaussian());
    }
    const PosePrior prior{truth * RandomPose(random, 0.05, 0.02), 0.1, 0.05};
    const Rigid2 found = RefinePose(field, points, prior, prior.field_from_robot).field_from_robot;
    const Eigen::Vector3d start = VectorOf(prior.field_from_robot), end = VectorOf(found);
    EXPECT_LT(SurpriseAt<double>(field, points, prior, end),
              SurpriseAt<double>(field, points, prior, start));
    EXPECT_LT(GradientAt(field, points, prior, end).norm(),
              0.01 * GradientAt(field, points, prior, start).norm())
        << round;
  }
}

TEST(Rigid2, ComposesLikeRigid3) {
  const Rigid2 a{1.2, {3, -1}}, b{2.5, {0.4, 7}};
  const Rigid3 expected = a.ToRigid3() * b.ToRigid3(), product = (a * b).ToRigid3();
  EXPECT_LT((product.translation - expected.translation).norm(), 1e-12);
  EXPECT_LT(AngleBetween_rad(product, expected), 1e-7);
  const Rigid2 identity = a * a.Inverse();
  EXPECT_LT(identity.translation.norm(), 1e-12);
  EXPECT_NEAR(identity.heading_rad, 0, 1e-12);
}

}  // namespace nightmap::match_scan_test
