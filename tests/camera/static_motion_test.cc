// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/static_motion.h"

#include <gtest/gtest.h>

#include <numeric>

#include "pipeline/base/random.h"
#include "tests/landmark_scene.h"

namespace nightmap::static_motion_test {

const Camera kCamera{640, 480, 500, 500, 320, 240};

Rigid3 Motion(double x_m, double angle_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY())), {x_m, 0, 0}};
}

// Matches of a thing that covers columns [begin_px, end_px) of the picture at some depth, and moves
// by target_from_source.
void Add(const Rigid3& target_from_source,
         int count,
         double begin_px,
         double end_px,
         double depth_m,
         Random& random,
         std::vector<PointMatch>* matches) {
  while (count > 0) {
    const Eigen::Vector2d pixel(random.Uniform(begin_px, end_px), random.Uniform(0, 480));
    const Eigen::Vector3d point =
        kCamera.BackProjectUndistorted(pixel, depth_m * random.Uniform(0.9, 1.1));
    const Eigen::Vector3d moved = target_from_source * point;
    const auto seen = kCamera.ProjectUndistorted(moved);
    if (!seen) continue;
    matches->push_back({*seen, point, moved.z(), 0});
    --count;
  }
}

const Rigid3 kCameraMotion = Motion(0.03, 0.02);
const Rigid3 kPersonMotion = Motion(-0.1, 0.0);

// Somebody 1.2 m away hides the left 60 % of a room that is 3 m deep, and has most of the matches.
std::vector<PointMatch> PersonBeforeRoom(std::uint64_t seed) {
  Random random(seed);
  std::vector<PointMatch> matches;
  Add(kPersonMotion, 300, 0, 384, 1.2, random, &matches);
  Add(kCameraMotion, 100, 384, 640, 3, random, &matches);
  return matches;
}

double Error(const AbsolutePose& pose, const Rigid3& truth) {
  return LeftError(pose.camera_from_world, truth).norm();
}

TEST(StaticMotion, IsTheRoomsAlsoWhereAPersonHasMostMatches) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto matches = PersonBeforeRoom(seed);
    const auto pose = EstimateStaticMotion(kCamera, matches, {.seed = seed}, 5);
    ASSERT_TRUE(pose);
    EXPECT_LT(Error(*pose, kCameraMotion), 1e-6) << seed;
    std::vector<int> of_room(100);
    std::iota(of_room.begin(), of_room.end(), 300);
    EXPECT_EQ(pose->inliers, of_room);
    const auto most = EstimateStaticMotion(kCamera, matches, {.seed = seed}, 1);
    ASSERT_TRUE(most);
    EXPECT_LT(Error(*most, kPersonMotion), 1e-6) << "one motion: that of most matches";
  }
}

TEST(StaticMotion, OfOneRigidSceneIsTheAbsolutePose) {
  Random random(1);
  std::vector<PointMatch> matches;
  Add(kCameraMotion, 200, 0, 640, 2, random, &matches);
  for (int i = 0; i < 40; ++i) matches[static_cast<std::size_t>(i)].pixel.x() += 50;
  const auto pose = EstimateStaticMotion(kCamera, matches, {.seed = 3}, 5);
  const auto expected = EstimateAbsolutePose(kCamera, matches, {.seed = 3});
  ASSERT_TRUE(pose && expected);
  EXPECT_EQ(pose->inliers, expected->inliers);
  EXPECT_EQ(pose->num_iterations, expected->num_iterations);
  EXPECT_EQ(Error(*pose, expected->camera_from_world), 0);
}

TEST(StaticMotion, IsNoneWhereNothingAgrees) {
  Random random(2);
  std::vector<PointMatch> matches;
  Add(kCameraMotion, 100, 0, 640, 2, random, &matches);
  for (PointMatch& match : matches) {
    match.pixel = {random.Uniform(0, 640), random.Uniform(0, 480)};
  }
  EXPECT_FALSE(EstimateStaticMotion(kCamera, matches, {}, 5));
  EXPECT_FALSE(EstimateStaticMotion(kCamera, {}, {}, 5));
}

double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(SurfaceAreas, CountAPlaceOnceHoweverManyMatchesItHas) {
  Random random(4);
  std::vector<PointMatch> matches;
  Add(Rigid3(), 4000, 0, 640, 2, random, &matches);
  const double area_m2 = Sum(SurfaceAreas_m2(kCamera, matches));
  EXPECT_NEAR(area_m2, 640.0 * 480 / (500 * 500) * 4, 0.05);
  matches.insert(matches.end(), matches.begin(), matches.begin() + 2000);
  EXPECT_NEAR(Sum(SurfaceAreas_m2(kCamera, matches)), area_m2, 0.05);
  for (PointMatch& match : matches) match.point_in_world *= 2;
  EXPECT_NEAR(Sum(SurfaceAreas_m2(kCamera, matches)), 4 * area_m2, 0.2) << "twice as far";
}

TEST(SurfaceAreas, OfPixelsOutsideThePictureAreThoseOfItsBorder) {
  const auto areas_m2 = SurfaceAreas_m2(
      kCamera, {{{-30, -30}, {0, 0, 1}}, {{5, 5}, {0, 0, 1}}, {{700, 500}, {0, 0, 1}}});
  const double cell_m = 640.0 / 24 / 500;
  EXPECT_NEAR(areas_m2[0], cell_m * cell_m / 2, 1e-12);
  EXPECT_NEAR(areas_m2[1], cell_m * cell_m / 2, 1e-12);
  EXPECT_NEAR(areas_m2[2], cell_m * cell_m, 1e-12);
}

}  // namespace nightmap::static_motion_test
