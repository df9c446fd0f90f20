// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/dlt.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "pipeline/base/random.h"

namespace nightmap::dlt_test {

struct Views {
  Rigid3 camera_from_world;
  std::vector<Eigen::Vector2d> rays;
  std::vector<Eigen::Vector3d> points;
};

// Points before a camera anywhere; with `flatness` 0 all are on one plane of the world.
Views MakeViews(int num_points, double flatness, Random& random) {
  Views views;
  const Eigen::Vector3d axis(random.Gaussian(), random.Gaussian(), random.Gaussian());
  views.camera_from_world.rotation = Eigen::AngleAxisd(random.Uniform(-3, 3), axis.normalized());
  views.camera_from_world.translation = {
      random.Uniform(-30, 30), random.Uniform(-30, 30), random.Uniform(-2, 2)};
  for (int i = 0; i < num_points; ++i) {
    const Eigen::Vector3d point(
        random.Uniform(-1, 1), random.Uniform(-1, 1), 3 + flatness * random.Uniform(-1, 1));
    views.rays.push_back(point.head<2>() / point.z());
    views.points.push_back(views.camera_from_world.Inverse() * point);
  }
  return views;
}

TEST(Dlt, IsExactForExactViews) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const Views views = MakeViews(seed % 2 == 0 ? 6 : 40, 1, random);
    const auto pose = SolveDlt(views.rays, views.points);
    ASSERT_TRUE(pose) << seed;
    const Rigid3 difference = *pose * views.camera_from_world.Inverse();
    EXPECT_LT(difference.translation.norm(), 1e-4) << seed;
    EXPECT_LT(AngleBetween_rad(difference, Rigid3()), 1e-5) << seed;
  }
}

TEST(Dlt, RefusesPointsThatDetermineNothing) {
  Random random(1);
  const Views plane = MakeViews(20, 0, random);
  EXPECT_FALSE(SolveDlt(plane.rays, plane.points));
  Views line = MakeViews(8, 1, random);
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const Eigen::Vector3d in_camera(0.1 * static_cast<double>(i), 0, 3);
    line.rays[i] = in_camera.head<2>() / 3;
    line.points[i] = line.camera_from_world.Inverse() * in_camera;
  }
  EXPECT_FALSE(SolveDlt(line.rays, line.points));
  Views one = MakeViews(6, 1, random);
  one.points.assign(6, one.points[0]);
  EXPECT_FALSE(SolveDlt(one.rays, one.points));
}

TEST(Dlt, RefusesAReflection) {
  Random random(2);
  Views views = MakeViews(12, 1, random);
  for (Eigen::Vector3d& point : views.points) point.x() = -point.x();
  EXPECT_FALSE(SolveDlt(views.rays, views.points));
}

TEST(Dlt, RefusesTooFewPoints) {
  Random random(3);
  const Views five = MakeViews(5, 1, random);
  EXPECT_THROW(SolveDlt(five.rays, five.points), std::invalid_argument);
  const Views six = MakeViews(6, 1, random);
  EXPECT_THROW(SolveDlt(six.rays, five.points), std::invalid_argument);
}

}  // namespace nightmap::dlt_test
