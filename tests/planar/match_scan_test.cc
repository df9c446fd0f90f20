// SPDX-License-Identifier: Apache-2.0
#include "pipeline/planar/match_scan.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

const LikelihoodFieldOptions kField{.resolution_m = 0.05, .half_extent_m = 8, .sigma_m = 0.08};

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

// The largest value of the search, by trying all of its poses.
double BestOfAll(const LikelihoodField& field,
                 const std::vector<Eigen::Vector2d>& points,
                 const PosePrior& prior) {
  double farthest_m = 0;
  for (const Eigen::Vector2d& point : points) farthest_m = std::max(farthest_m, point.norm());
  const double step_rad = 2 * 0.05 / farthest_m;
  const int num_turns = static_cast<int>(std::ceil(3 * prior.sigma_rad / step_rad));
  const int num_cells = static_cast<int>(std::ceil(3 * prior.sigma_m / 0.05));
  double best = -1e9;
  for (int turn = -num_turns; turn <= num_turns; ++turn) {
    for (int row = -num_cells; row <= num_cells; ++row) {
      for (int column = -num_cells; column <= num_cells; ++column) {
        Rigid2 pose = prior.field_from_robot;
        pose.heading_rad += turn * step_rad;
        pose.translation += 0.05 * Eigen::Vector2d(column, row);
        const double errors =
            std::pow(turn * step_rad / prior.sigma_rad, 2) +
            (std::pow(row, 2) + std::pow(column, 2)) * std::pow(0.05 / prior.sigma_m, 2);
        best = std::max(best, ScoreOf(field, points, pose) - kPriorWeight * errors);
      }
    }
  }
  return best;
}

TEST(SearchPose, FindsWhatTryingAllPosesFinds) {
  Random random(3);
  for (int round = 0; round < 200; ++round) {
    LikelihoodField field(kField);
    std::vector<Eigen::Vector2d> walls, scan;
    for (int i = 0; i < 60; ++i) walls.push_back({random.Uniform(-4, 4), random.Uniform(-4, 4)});
    field.Add(walls);
    const Rigid2 truth = RandomPose(random, 0.3, 0.2);
    for (int i = 0; i < 25; ++i) scan.push_back(walls[random.Index(walls.size())]);
    const auto points = SeenFrom(truth, scan);
    const PosePrior prior{RandomPose(random, 0.1, 0.1), 0.12, 0.05};
    const Rigid2 found = SearchPose(field, points, prior);
    const double shift = (found.translation - prior.field_from_robot.translation).norm() / 0.12;
    const double turn = (found.heading_rad - prior.field_from_robot.heading_rad) / 0.05;
    const double value =
        ScoreOf(field, points, found) - kPriorWeight * (shift * shift + turn * turn);
    ASSERT_NEAR(value, BestOfAll(field, points, prior), 1e-5) << round;
  }
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
    const ScanMatch match = MatchScan(field, points, prior);
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
  const ScanMatch match = MatchScan(field, points, {{0, {0.02, 0.03}}, 0.1, 0.05});
  EXPECT_NEAR(std::sqrt(match.covariance(0, 0)), 0.1, 0.02);
  EXPECT_LT(std::sqrt(match.covariance(1, 1)), 0.03);
  EXPECT_NEAR(match.field_from_robot.translation.x(), 0.02, 0.02);
  EXPECT_NEAR(match.field_from_robot.translation.y(), 0, 0.01);
}

TEST(MatchScan, WithoutPointsThePriorStays) {
  const LikelihoodField field(kField);
  const ScanMatch match = MatchScan(field, {}, {{0.2, {1, 2}}, 0.1, 0.05});
  EXPECT_NEAR(match.field_from_robot.translation.x(), 1, 1e-9);
  EXPECT_NEAR(match.field_from_robot.heading_rad, 0.2, 1e-9);
  EXPECT_EQ(match.score, 0);
  EXPECT_NEAR(match.covariance(0, 0), 0.01, 1e-9);
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

}  // namespace
}  // namespace nightmap
