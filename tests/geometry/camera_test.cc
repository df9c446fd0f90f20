// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/depth_noise.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace nightmap::camera_test {

// The Kinect of TUM's freiburg1 sequences: strong distortion, k3 included.
Camera Freiburg1() {
  return {.width = 640,
          .height = 480,
          .fx = 517.3,
          .fy = 516.5,
          .cx = 318.6,
          .cy = 255.3,
          .k1 = 0.2624,
          .k2 = -0.9531,
          .p1 = -0.0054,
          .p2 = 0.0026,
          .k3 = 1.1633};
}

TEST(Camera, ProjectUndoesBackProjectUnderStrongDistortion) {
  const Camera camera = Freiburg1();
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector2d pixel(random.Uniform(0, 639), random.Uniform(0, 479));
    const double depth_m = random.Uniform(0.3, 10);
    const Eigen::Vector3d point = camera.BackProject(pixel, depth_m);
    EXPECT_DOUBLE_EQ(point.z(), depth_m);
    const auto projected = camera.Project(point);
    ASSERT_TRUE(projected) << pixel.transpose();
    ASSERT_LT((*projected - pixel).norm(), 1e-3) << pixel.transpose();
  }
}

TEST(Camera, UndistortedPixelIsTheSameRayWithoutDistortion) {
  const Camera camera = Freiburg1();
  Camera pinhole = camera;
  pinhole.k1 = pinhole.k2 = pinhole.p1 = pinhole.p2 = pinhole.k3 = 0;
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d pixel(random.Uniform(0, 639), random.Uniform(0, 479));
    const Eigen::Vector2d undistorted = camera.Undistort(pixel);
    EXPECT_LT((pinhole.Normalize(undistorted) - camera.Normalize(pixel)).norm(), 1e-12);
  }
  // It must do something in the corner, and nothing at the principal point.
  EXPECT_GT((camera.Undistort({0, 0}) - Eigen::Vector2d(0, 0)).norm(), 1);
  EXPECT_LT((camera.Undistort({318.6, 255.3}) - Eigen::Vector2d(318.6, 255.3)).norm(), 1e-9);
}

TEST(Camera, EachCoefficientHasItsPlaceInTheModel) {
  Camera camera{.width = 100, .height = 100, .fx = 100, .fy = 200, .cx = 50, .cy = 60};
  const Eigen::Vector3d point(0.2, 0.4, 2);  // x = 0.1, y = 0.2, r2 = 0.05
  EXPECT_TRUE(camera.Project(point)->isApprox(Eigen::Vector2d(60, 100)));
  const auto shift = [&](double Camera::*coefficient) -> Eigen::Vector2d {
    Camera distorted = camera;
    distorted.*coefficient = 0.1;
    const Eigen::Vector2d moved = *distorted.Project(point) - *camera.Project(point);
    return {moved.x() / 100, moved.y() / 200};
  };
  EXPECT_TRUE(shift(&Camera::k1).isApprox(0.1 * 0.05 * Eigen::Vector2d(0.1, 0.2)));
  EXPECT_TRUE(shift(&Camera::k2).isApprox(0.1 * 0.05 * 0.05 * Eigen::Vector2d(0.1, 0.2), 1e-6));
  EXPECT_TRUE(shift(&Camera::k3).isApprox(0.1 * 1.25e-4 * Eigen::Vector2d(0.1, 0.2), 1e-6));
  EXPECT_TRUE(shift(&Camera::p1).isApprox(0.1 * Eigen::Vector2d(0.04, 0.13)));
  EXPECT_TRUE(shift(&Camera::p2).isApprox(0.1 * Eigen::Vector2d(0.07, 0.04)));
}

TEST(Camera, PointsBehindProjectNowhere) {
  const Camera camera = Freiburg1();
  EXPECT_FALSE(camera.Project({0.1, 0.1, 0}));
  EXPECT_FALSE(camera.Project({0.1, 0.1, -1}));
  EXPECT_FALSE(camera.Project({0.1, 0.1, std::numeric_limits<double>::quiet_NaN()}));
}

TEST(Camera, PointsBeyondTheTurningPointDoNotFoldIntoTheImage) {
  const Camera camera{
      .width = 100, .height = 100, .fx = 50, .fy = 50, .cx = 50, .cy = 50, .k1 = -0.3};
  EXPECT_TRUE(camera.Project({0.9, 0, 1}));
  EXPECT_FALSE(camera.Project({1.8, 0, 1}));  // the polynomial would put it at x = 52
}

TEST(Camera, DistortionOfAnotherOrderFoldsThePicture) {
  const Camera camera = Freiburg1();
  EXPECT_LT(LargestDistortion(camera), 0.1);
  EXPECT_GT(LargestDistortion(camera), 0.001);
  Camera third = camera;  // k1 k2 k3 p1 p2 read as k1 k2 p1 p2 k3
  third.p1 = camera.k3;
  third.p2 = camera.p1;
  third.k3 = camera.p2;
  EXPECT_GT(LargestDistortion(third), 0.5);
  const Camera wide{.width = 1920,
                    .height = 1080,
                    .fx = 880,
                    .fy = 880,
                    .cx = 960,
                    .cy = 540,
                    .k1 = -0.26,
                    .k2 = 0.07};
  EXPECT_LT(LargestDistortion(wide), 0.3);
  const Camera none{.width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 32, .cy = 24};
  EXPECT_LT(LargestDistortion(none), 1e-9);
}

TEST(DepthNoise, GrowsWithDepthSquared) {
  const DepthNoise noise{.constant_m = 0.001, .quadratic_per_m = 0.002};
  EXPECT_DOUBLE_EQ(noise.Sigma_m(0), 0.001);
  EXPECT_DOUBLE_EQ(noise.Sigma_m(3), 0.019);
}

}  // namespace nightmap::camera_test
