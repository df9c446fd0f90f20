// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/upward_camera.h"

#include "pipeline/base/random.h"
#include "pipeline/ceiling/planar_pose.h"
#include "tests/ceiling/numeric_derivative.h"
#include "tests/test_data.h"

namespace nightmap::upward_camera_test {

UpwardCamera MakeCamera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 320;
  camera.fy = 330;
  camera.cx = 319.5;
  camera.cy = 239.5;
  // Turned about the vertical, and not quite level.
  const Eigen::Quaterniond turned(
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.1, -0.05, 1).normalized()));
  return {camera, {turned, {0.1, -0.03, 0.35}}};
}

struct Case {
  Eigen::Vector3d pose, point;
  Eigen::Vector2d tilt_rad;
};

std::vector<Case> MakeCases() {
  std::vector<Case> cases;
  for (std::uint64_t i = 0; i < 20; ++i) {
    Random random(4, 0, i);
    const auto next = [&] { return random.Gaussian(); };
    Case one;
    one.pose = {next(), next(), 2 * next()};
    one.tilt_rad = {0.02 * next(), 0.02 * next()};
    one.point = one.pose + Eigen::Vector3d(next(), next(), 0);
    one.point.z() = 2.6 + 0.3 * next();
    cases.push_back(one);
  }
  return cases;
}

TEST(UpwardCamera, DerivativesAreThoseOfNumbers) {
  const UpwardCamera camera = MakeCamera();
  for (const Case& c : MakeCases()) {
    const auto p = camera.Project(c.pose, c.tilt_rad, c.point);
    ASSERT_TRUE(p);
    const auto by = [&](const auto& f, const auto& at) { return NumericDerivative(f, at); };
    EXPECT_LT((p->by_pose - by(
                                [&](const Eigen::VectorXd& pose) -> Eigen::VectorXd {
                                  return camera.Project(pose, c.tilt_rad, c.point)->pixel;
                                },
                                c.pose))
                  .norm(),
              1e-4);
    EXPECT_LT((p->by_tilt - by(
                                [&](const Eigen::VectorXd& tilt) -> Eigen::VectorXd {
                                  return camera.Project(c.pose, tilt, c.point)->pixel;
                                },
                                c.tilt_rad))
                  .norm(),
              2e-3);
    EXPECT_LT((p->by_point - by(
                                 [&](const Eigen::VectorXd& point) -> Eigen::VectorXd {
                                   return camera.Project(c.pose, c.tilt_rad, point)->pixel;
                                 },
                                 c.point))
                  .norm(),
              1e-4);
    const auto ray = camera.PointAt(c.pose, c.tilt_rad, p->pixel, p->depth_m);
    EXPECT_LT(
        (ray.by_pose - by(
                           [&](const Eigen::VectorXd& pose) -> Eigen::VectorXd {
                             return camera.PointAt(pose, c.tilt_rad, p->pixel, p->depth_m).point;
                           },
                           c.pose))
            .norm(),
        1e-6);
    EXPECT_LT((ray.by_tilt - by(
                                 [&](const Eigen::VectorXd& tilt) -> Eigen::VectorXd {
                                   return camera.PointAt(c.pose, tilt, p->pixel, p->depth_m).point;
                                 },
                                 c.tilt_rad))
                  .norm(),
              5e-5);
    EXPECT_LT(
        (ray.by_pixel - by(
                            [&](const Eigen::VectorXd& pixel) -> Eigen::VectorXd {
                              return camera.PointAt(c.pose, c.tilt_rad, pixel, p->depth_m).point;
                            },
                            p->pixel))
            .norm(),
        1e-6);
  }
}

TEST(UpwardCamera, PointAtIsTheInverseOfProject) {
  const UpwardCamera camera = MakeCamera();
  for (const Case& c : MakeCases()) {
    const auto p = camera.Project(c.pose, c.tilt_rad, c.point);
    const auto ray = camera.PointAt(c.pose, c.tilt_rad, p->pixel, p->depth_m);
    EXPECT_LT((ray.point - c.point).norm(), 1e-9);
  }
}

TEST(UpwardCamera, SeesNothingBehindIt) {
  EXPECT_FALSE(MakeCamera().Project({0, 0, 0}, {0, 0}, {0, 0, 0.2}));
}

TEST(UpwardCamera, TriangulatesWhereTheRobotMoved) {
  const UpwardCamera camera = MakeCamera();
  for (const Case& c : MakeCases()) {
    const Eigen::Vector3d moved = c.pose + Eigen::Vector3d(0.4, 0.1, 0.2);
    const auto a = camera.Project(c.pose, c.tilt_rad, c.point);
    const auto b = camera.Project(moved, c.tilt_rad, c.point);
    const UpwardCamera::View first{c.pose, c.tilt_rad, a->pixel},
        second{moved, c.tilt_rad, b->pixel};
    const auto depth_m = camera.Triangulate(first, second, 0.02);
    ASSERT_TRUE(depth_m);
    EXPECT_NEAR(*depth_m, b->depth_m, 1e-9);
  }
}

// The publication's Z = f T / (x1 - x2), of a camera that moves along its x.
TEST(UpwardCamera, TriangulationIsThatOfThePublication) {
  Camera pinhole;
  pinhole.fx = pinhole.fy = 320;
  const UpwardCamera camera(pinhole, {});
  const UpwardCamera::View first{{0, 0, 0}, {0, 0}, {50, 20}},
      second{{0.2, 0, 0}, {0, 0}, {20, 20}};
  EXPECT_NEAR(*camera.Triangulate(first, second, 0.01), 320 * 0.2 / (50 - 20), 1e-9);
}

TEST(UpwardCamera, RefusesAViewFromTheSamePlace) {
  Camera pinhole;
  pinhole.fx = pinhole.fy = 320;
  const UpwardCamera camera(pinhole, {});
  const auto a = camera.Project({0, 0, 0}, {0, 0}, {0.5, 0.3, 2});
  for (const Eigen::Vector3d& turned : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.01, 0, 0)}) {
    const auto b = camera.Project(turned, {0, 0}, {0.5, 0.3, 2});
    EXPECT_FALSE(
        camera.Triangulate({{0, 0, 0}, {0, 0}, a->pixel}, {turned, {0, 0}, b->pixel}, 0.02));
  }
}

TEST(PlanarPose, DerivativesAreThoseOfNumbers) {
  for (const Case& c : MakeCases()) {
    const Eigen::Vector3d a = c.pose, b = c.point;
    const auto by = [](const auto& f, const auto& at) { return NumericDerivative(f, at); };
    const ComposedPose composed = Compose(a, b), between = Between(a, b);
    const SeenPoint seen = PointFrom(a, b);
    using V = Eigen::VectorXd;
    EXPECT_LT(
        (composed.by_first - by([&](const V& x) -> V { return Compose(x, b).pose; }, a)).norm(),
        1e-6);
    EXPECT_LT(
        (composed.by_second - by([&](const V& x) -> V { return Compose(a, x).pose; }, b)).norm(),
        1e-6);
    EXPECT_LT(
        (between.by_first - by([&](const V& x) -> V { return Between(x, b).pose; }, a)).norm(),
        1e-6);
    EXPECT_LT(
        (between.by_second - by([&](const V& x) -> V { return Between(a, x).pose; }, b)).norm(),
        1e-6);
    EXPECT_LT((seen.by_pose - by([&](const V& x) -> V { return PointFrom(x, b).point; }, a)).norm(),
              1e-6);
    EXPECT_LT(
        (seen.by_point - by([&](const V& x) -> V { return PointFrom(a, x).point; }, b)).norm(),
        1e-6);
    const Eigen::Vector3d back = Compose(a, Between(a, b).pose).pose;
    EXPECT_LT((back - b).norm(), 1e-12);
  }
}

}  // namespace nightmap::upward_camera_test
