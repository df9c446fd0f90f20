// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/disparity_depth.h"

#include <numbers>

#include "tests/ceiling/numeric_derivative.h"
#include "tests/test_data.h"

namespace nightmap::disparity_depth_test {

UpwardCamera MakeCamera(double mounting_rad) {
  Camera camera;
  camera.fx = 320;
  camera.fy = 330;
  camera.cx = 319.5;
  camera.cy = 239.5;
  const Eigen::AngleAxisd turned(mounting_rad, Eigen::Vector3d(0.1, -0.05, 1).normalized());
  return {camera, {Eigen::Quaterniond(turned), {0.1, -0.03, 0.35}}};
}

const Eigen::Vector3d kFirst(0.2, -0.1, 0.7), kPoint(0.9, 0.3, 2.6);

Eigen::Vector2d Seen(const UpwardCamera& camera, const Eigen::Vector3d& pose) {
  return camera.Project(pose, {0, 0}, kPoint)->pixel;
}

TEST(DisparityDepth, IsExactWhereverTheRobotMoved) {
  const UpwardCamera camera = MakeCamera(0.4);
  for (double heading_rad = 0; heading_rad < 2 * std::numbers::pi; heading_rad += 0.5) {
    for (const double turn_rad : {0.0, 0.3}) {
      const Eigen::Vector3d way(
          0.06 * std::cos(heading_rad), 0.06 * std::sin(heading_rad), turn_rad);
      const Eigen::Vector3d second = kFirst + way;
      const auto depth =
          DepthByDisparity(camera, kFirst, Seen(camera, kFirst), second, Seen(camera, second));
      ASSERT_TRUE(depth);
      EXPECT_NEAR(depth->depth_m, camera.Project(second, {0, 0}, kPoint)->depth_m, 1e-9);
    }
  }
}

TEST(DisparityDepth, IsThatOfThePublicationAlongX) {
  Camera pinhole;
  pinhole.fx = pinhole.fy = 320;
  // A corner that strays across the way has the same depth.
  for (const double y : {20.0, 23.0}) {
    const auto depth =
        DepthByDisparity(UpwardCamera(pinhole, {}), {0, 0, 0}, {50, 20}, {0.2, 0, 0}, {20, y});
    EXPECT_NEAR(depth->depth_m, 320 * 0.2 / (50 - 20), 1e-9);
  }
}

TEST(DisparityDepth, WithoutDisparityThereIsNone) {
  const UpwardCamera camera = MakeCamera(0);
  const Eigen::Vector3d first(0, 0, 0), second(0.1, 0, 0);
  const Eigen::Vector2d pixel(400, 200);
  EXPECT_FALSE(DepthByDisparity(camera, first, pixel, second, pixel));
  EXPECT_FALSE(DepthByDisparity(camera, first, pixel, second, pixel + Eigen::Vector2d(5, 0)));
  EXPECT_FALSE(DepthByDisparity(camera, first, pixel, first, pixel - Eigen::Vector2d(5, 0)));
  EXPECT_FALSE(DepthByDisparity(camera, first, pixel, second, {-1e6, 200}));  // in the lens
  EXPECT_FALSE(DepthByDisparity(camera, first, {std::nan(""), 200}, second, pixel));
}

TEST(DisparityDepth, DerivativesAreThoseOfNumbers) {
  const UpwardCamera camera = MakeCamera(0.4);
  const Eigen::Vector3d second = kFirst + Eigen::Vector3d(0.3, 0.1, 0.2);
  const Eigen::Vector2d a = Seen(camera, kFirst), b = Seen(camera, second);
  const auto depth = DepthByDisparity(camera, kFirst, a, second, b);
  const auto by = [](const auto& depth_at, const Eigen::VectorXd& at) {
    return NumericDerivative(
        [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
          return Eigen::VectorXd::Constant(1, depth_at(x)->depth_m);
        },
        at);
  };
  using V = Eigen::VectorXd;
  const auto near = [](const Eigen::MatrixXd& analytic, const Eigen::MatrixXd& numeric) {
    EXPECT_LT((analytic - numeric).norm(), 1e-5 * numeric.norm());
    EXPECT_GT(numeric.norm(), 0);
  };
  near(depth->by_first.pose,
       by([&](const V& x) { return DepthByDisparity(camera, x, a, second, b); }, kFirst));
  near(depth->by_second.pose,
       by([&](const V& x) { return DepthByDisparity(camera, kFirst, a, x, b); }, second));
  near(depth->by_first.pixel,
       by([&](const V& x) { return DepthByDisparity(camera, kFirst, x, second, b); }, a));
  near(depth->by_second.pixel,
       by([&](const V& x) { return DepthByDisparity(camera, kFirst, a, second, x); }, b));
}

}  // namespace nightmap::disparity_depth_test
