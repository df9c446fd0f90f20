// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/search_pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::search_pose_test {

constexpr int kNumLevels = 4;
constexpr double kCell_m = 0.05;
constexpr LikelihoodFieldOptions kField{
    .resolution_m = kCell_m, .half_extent_m = 3, .sigma_m = 0.08};

// A scan of some points of a field, seen from near the origin, and where to look for it.
struct Scene {
  explicit Scene(Random& random) : field(kField) {
    std::vector<Eigen::Vector2d> walls;
    for (int i = 0; i < 50; ++i) walls.push_back({random.Uniform(-3, 3), random.Uniform(-3, 3)});
    field.Add(walls);
    const Rigid2 truth{random.Uniform(-0.2, 0.2),
                       {random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3)}};
    for (int i = 0; i < 20; ++i) {
      points.push_back(truth.Inverse() * walls[random.Index(walls.size())]);
    }
    window.center = {random.Uniform(-0.1, 0.1),
                     {random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1)}};
    window.half_extent_m = random.Uniform(0, 0.45);
    window.half_angle_rad = random.Uniform(0, 0.2);
    window.min_value = -100;
  }

  LikelihoodField field;
  std::vector<Eigen::Vector2d> points;
  SearchWindow window;
};

bool IsLeftOut(const SearchWindow& window, const Rigid2& pose) {
  if (!window.not_near) return false;
  const double turn_rad = WrapAngle_rad(pose.heading_rad - window.not_near->heading_rad);
  const double shift_m = (pose.translation - window.not_near->translation).norm();
  return std::abs(turn_rad) <= window.near_rad && shift_m <= window.near_m;
}

// Value of a shift by whole cells: level 0 of the pyramid at the points, less the penalties.
double ValueAt(const FieldPyramid& pyramid, const Scene& scene, const Rigid2& pose) {
  const SearchWindow& window = scene.window;
  const Rigid2 turned{pose.heading_rad, window.center.translation};
  const Eigen::Vector2i shift =
      ((pose.translation - window.center.translation) / kCell_m).array().round().cast<int>();
  int sum = 0;
  for (const Eigen::Vector2d& point : scene.points) {
    const Eigen::Vector2i cell =
        scene.field.ToCells(turned * point).array().round().cast<int>() + shift.array();
    sum += pyramid.At(0, cell.x(), cell.y());
  }
  return sum / (255.0 * static_cast<double>(scene.points.size())) -
         window.penalty_per_m2 * (pose.translation - window.center.translation).squaredNorm() -
         window.penalty_per_rad2 * std::pow(pose.heading_rad - window.center.heading_rad, 2);
}

// Values of all poses of the window, the largest first.
std::vector<double> AllValues(const FieldPyramid& pyramid, const Scene& scene) {
  const SearchWindow& window = scene.window;
  const HeadingSteps headings = HeadingStepsOf(window, kCell_m, scene.points);
  const int num_cells = static_cast<int>(std::ceil(window.half_extent_m / kCell_m));
  std::vector<double> values;
  for (int turn = -headings.num_turns; turn <= headings.num_turns; ++turn) {
    for (int row = -num_cells; row <= num_cells; ++row) {
      for (int column = -num_cells; column <= num_cells; ++column) {
        const Rigid2 pose{window.center.heading_rad + turn * headings.step_rad,
                          window.center.translation + kCell_m * Eigen::Vector2d(column, row)};
        if (!IsLeftOut(window, pose)) values.push_back(ValueAt(pyramid, scene, pose));
      }
    }
  }
  std::ranges::sort(values, std::greater());
  return values;
}

void ExpectTheBestOfAll(const Scene& scene, int num_levels = kNumLevels) {
  const FieldPyramid pyramid(scene.field, num_levels);
  const auto found = SearchPose(pyramid, scene.points, scene.window);
  const auto values = AllValues(pyramid, scene);
  ASSERT_EQ(found.has_value(), !values.empty());
  if (!found) return;
  EXPECT_NEAR(found->value, values.front(), 1e-12);
  EXPECT_NEAR(found->value, ValueAt(pyramid, scene, found->field_from_robot), 1e-12);
  EXPECT_FALSE(IsLeftOut(scene.window, found->field_from_robot));
}

TEST(SearchPose, FindsWhatTryingAllPosesFinds) {
  Random random(3);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    Scene scene(random);
    ExpectTheBestOfAll(scene, 1 + round % 6);
  }
}

TEST(SearchPoses, FindsAllPosesThatComeNearTheBest) {
  Random random(31);
  std::size_t num_found = 0;
  for (int round = 0; round < 100; ++round) {
    SCOPED_TRACE(round);
    Scene scene(random);
    scene.window.min_value = random.Uniform(0, 0.2);
    const double share = random.Uniform(0.6, 1);
    const FieldPyramid pyramid(scene.field, kNumLevels);
    const auto found = SearchPoses(pyramid, scene.points, scene.window, share);
    std::vector<double> expected = AllValues(pyramid, scene);
    const double least = std::max(scene.window.min_value, share * expected.front());
    std::erase_if(expected, [&](double value) { return value <= least; });
    // Some poses at the limit itself may be left out, as the best where the share is 1.
    ASSERT_GE(found.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(found[i].value, expected[i], 1e-12);
      EXPECT_NEAR(found[i].value, ValueAt(pyramid, scene, found[i].field_from_robot), 1e-12);
    }
    num_found += found.size();
  }
  EXPECT_GT(num_found, 500U);
}

TEST(SearchPose, PenaltiesComeOffTheScore) {
  Random random(4);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    Scene scene(random);
    scene.window.penalty_per_m2 = random.Uniform(0, 5);
    scene.window.penalty_per_rad2 = random.Uniform(0, 10);
    ExpectTheBestOfAll(scene);
    const FieldPyramid pyramid(scene.field, kNumLevels);
    const FoundPose found = SearchPose(pyramid, scene.points, scene.window).value();
    const Rigid2& center = scene.window.center;
    const double penalty =
        scene.window.penalty_per_m2 *
            (found.field_from_robot.translation - center.translation).squaredNorm() +
        scene.window.penalty_per_rad2 *
            std::pow(found.field_from_robot.heading_rad - center.heading_rad, 2);
    EXPECT_NEAR(found.score - penalty, found.value, 1e-12);
  }
}

TEST(SearchPose, FindsTheBestOnlyAboveTheSmallestValue) {
  Random random(5);
  for (int round = 0; round < 50; ++round) {
    SCOPED_TRACE(round);
    Scene scene(random);
    scene.window.penalty_per_m2 = random.Uniform(0, 5);
    const FieldPyramid pyramid(scene.field, kNumLevels);
    const double best = AllValues(pyramid, scene).front();
    scene.window.min_value = best - 1e-9;
    const auto found = SearchPose(pyramid, scene.points, scene.window);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->value, best, 1e-12);
    scene.window.min_value = best + 1e-9;
    EXPECT_FALSE(SearchPose(pyramid, scene.points, scene.window));
  }
}

TEST(SearchPose, LeavesOutPosesNearOne) {
  Random random(6);
  int num_changed = 0;
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    Scene scene(random);
    const FieldPyramid pyramid(scene.field, kNumLevels);
    const FoundPose first = SearchPose(pyramid, scene.points, scene.window).value();
    // Off the tried poses, so that none lies at the limit.
    scene.window.not_near = first.field_from_robot;
    scene.window.not_near->translation += Eigen::Vector2d(0.0031, -0.0017);
    scene.window.not_near->heading_rad += 2 * std::numbers::pi + 0.0013;
    scene.window.near_m = random.Uniform(0.01, 0.4);
    scene.window.near_rad = random.Uniform(0.002, 0.15);
    ExpectTheBestOfAll(scene);
    const auto second = SearchPose(pyramid, scene.points, scene.window);
    if (second && second->value < first.value) ++num_changed;
  }
  EXPECT_GT(num_changed, 100);
}

TEST(SearchPose, FindsNothingWhenAllPosesAreLeftOut) {
  Random random(7);
  Scene scene(random);
  scene.window.not_near = scene.window.center;
  scene.window.near_m = 10;
  scene.window.near_rad = 4;
  EXPECT_FALSE(SearchPose(FieldPyramid(scene.field, kNumLevels), scene.points, scene.window));
}

TEST(SearchPose, TheOrderOfPointsDoesNotMatter) {
  Random random(8);
  for (int round = 0; round < 50; ++round) {
    SCOPED_TRACE(round);
    Scene scene(random);
    const FieldPyramid pyramid(scene.field, kNumLevels);
    const FoundPose first = SearchPose(pyramid, scene.points, scene.window).value();
    std::ranges::reverse(scene.points);
    const FoundPose again = SearchPose(pyramid, scene.points, scene.window).value();
    EXPECT_NEAR(again.value, first.value, 1e-12);
    EXPECT_EQ(again.score, first.score);
    EXPECT_LT((again.field_from_robot.translation - first.field_from_robot.translation).norm(),
              1e-12);
    EXPECT_NEAR(again.field_from_robot.heading_rad, first.field_from_robot.heading_rad, 1e-12);
  }
}

// At the border and in the corner of the field, and outside of it.
TEST(SearchPose, WindowsMayReachBeyondTheField) {
  Random random(9);
  for (int round = 0; round < 100; ++round) {
    SCOPED_TRACE(round);
    Scene scene(random);
    scene.window.penalty_per_m2 = 0.1;
    scene.window.center.translation = {random.Uniform(-6, 6), random.Uniform(2, 6)};
    ExpectTheBestOfAll(scene);
  }
  Scene scene(random);
  scene.window.center = {0.5, {100, -100}};
  scene.window.penalty_per_m2 = scene.window.penalty_per_rad2 = 1;
  const FieldPyramid pyramid(scene.field, kNumLevels);
  const FoundPose found = SearchPose(pyramid, scene.points, scene.window).value();
  EXPECT_EQ(found.score, 0);
  EXPECT_EQ(found.field_from_robot.heading_rad, 0.5);
  EXPECT_EQ(found.field_from_robot.translation, Eigen::Vector2d(100, -100));
}

// A robot that was turned round, by any angle.
TEST(SearchPose, FindsAPoseWhateverItsHeading) {
  Random random(10);
  for (int round = 0; round < 20; ++round) {
    SCOPED_TRACE(round);
    Scene scene(random);
    const Rigid2 turned{random.Uniform(-3.1, 3.1), {0, 0}};
    for (Eigen::Vector2d& point : scene.points) point = turned * point;
    scene.window.half_angle_rad = std::numbers::pi;
    scene.window.half_extent_m = 0.4;
    ExpectTheBestOfAll(scene);
    const FieldPyramid pyramid(scene.field, kNumLevels);
    EXPECT_GT(SearchPose(pyramid, scene.points, scene.window).value().score, 0.5);
  }
}

TEST(SearchPose, WithoutAFieldNoPoseScores) {
  Random random(11);
  Scene scene(random);
  scene.field = LikelihoodField(kField);
  const FieldPyramid pyramid(scene.field, kNumLevels);
  EXPECT_EQ(SearchPose(pyramid, scene.points, scene.window).value().score, 0);
  scene.window.min_value = 0;
  EXPECT_FALSE(SearchPose(pyramid, scene.points, scene.window));
}

TEST(SearchPose, WithoutPointsThereIsNone) {
  const LikelihoodField field(kField);
  SearchWindow window;
  window.half_extent_m = 1;
  window.min_value = -1;
  EXPECT_FALSE(SearchPose(FieldPyramid(field, kNumLevels), {}, window));
}

// Points at 2 m move by 1.5 cells per step, and the steps reach the angle of the window.
TEST(HeadingSteps, AreSoDenseThatPointsMoveByFewCells) {
  SearchWindow window;
  window.half_angle_rad = 0.3;
  const HeadingSteps steps = HeadingStepsOf(window, kCell_m, {{2, 0}, {0, -2}});
  EXPECT_NEAR(steps.step_rad * 2, kHeadingStep_cells * kCell_m, 1e-12);
  EXPECT_GE(steps.num_turns * steps.step_rad, 0.3);
  EXPECT_LT((steps.num_turns - 1) * steps.step_rad, 0.3);
  EXPECT_EQ(HeadingStepsOf({}, kCell_m, {}).num_turns, 0);
}

// Once around is enough, whatever the window.
TEST(HeadingSteps, GoAroundOnce) {
  SearchWindow window;
  window.half_angle_rad = 100;
  const HeadingSteps steps = HeadingStepsOf(window, kCell_m, {{2, 0}, {0, -2}});
  EXPECT_GE(steps.num_turns * steps.step_rad, std::numbers::pi);
  EXPECT_LT((steps.num_turns - 1) * steps.step_rad, std::numbers::pi);
}

}  // namespace nightmap::search_pose_test
