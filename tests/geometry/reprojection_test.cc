// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/reprojection.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace nightmap::reprojection_test {

const Camera kCamera{640, 480, 525, 520, 319.5, 239.5};

// Everything the residual depends on: pose, point, motion and calibration.
struct Scene {
  using Step = Eigen::Matrix<double, 18, 1>;

  Rigid3 camera_from_world;
  Eigen::Vector3d point_in_world;
  PointMotion motion;
  CameraCalibration calibration;
  PointMeasurement measured;

  explicit Scene(Random& random) {
    const auto noise = [&] {
      return Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
    };
    Vector6d pose_step;
    pose_step << 0.3 * noise(), noise();
    camera_from_world = PerturbLeft(pose_step, Rigid3());
    point_in_world =
        camera_from_world.Inverse() *
        Eigen::Vector3d(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(1, 5));
    motion = {noise(), noise()};
    calibration = {random.Uniform(0.9, 1.1), random.Uniform(-0.03, 0.03), random.Uniform(0.9, 1.1)};
    measured = {
        {random.Uniform(0, 640), random.Uniform(0, 480)}, 2.5, 1 / 0.7, random.Uniform(0, 60)};
  }

  Scene Stepped(const Step& step, DepthCalibration by) const {
    Scene moved = *this;
    moved.camera_from_world = PerturbLeft(step.head<6>(), camera_from_world);
    moved.point_in_world += step.segment<3>(6);
    moved.motion.angular_rad_per_s += step.segment<3>(9);
    moved.motion.linear_m_per_s += step.segment<3>(12);
    moved.calibration.focal_scale += step[15];
    moved.calibration.readout_s += step[16];
    (by == DepthCalibration::kOffset ? moved.calibration.depth_offset_m
                                     : moved.calibration.depth_scale) += step[17];
    return moved;
  }

  Reprojection Reproject() const {
    return {kCamera,
            camera_from_world * point_in_world,
            RowFraction(kCamera, measured.pixel),
            motion,
            calibration};
  }

  Eigen::Matrix<double, 3, 18> Derivatives(DepthCalibration moved) const {
    const Reprojection seen = Reproject();
    const Eigen::Matrix3d by_p = seen.ByMovedPoint(measured);
    const Eigen::Matrix3d by_middle = seen.ByMiddlePoint(by_p);
    Eigen::Matrix<double, 3, 18> derivatives;
    derivatives << seen.ByPose(by_middle),
        by_middle * camera_from_world.rotation.toRotationMatrix(),
        calibration.readout_s * seen.ByMotion(by_p), seen.ByCalibration(measured, by_p, moved);
    return derivatives;
  }
};

TEST(Reprojection, DerivativesAreThoseOfFiniteDifferences) {
  constexpr double kStep = 1e-6;
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const auto by = trial % 2 == 0 ? DepthCalibration::kScale : DepthCalibration::kOffset;
    const Scene scene(random);
    const Eigen::Matrix<double, 3, 18> derivatives = scene.Derivatives(by);
    for (int k = 0; k < 18; ++k) {
      const Scene::Step step = kStep * Scene::Step::Unit(k);
      const Eigen::Vector3d difference =
          (scene.Stepped(step, by).Reproject().Residual(scene.measured) -
           scene.Stepped(-step, by).Reproject().Residual(scene.measured)) /
          (2 * kStep);
      EXPECT_LT((derivatives.col(k) - difference).norm(), 1e-5 * (1 + difference.norm()))
          << trial << " " << k;
    }
  }
}

TEST(Reprojection, ACameraThatStandsStillIsOneWithoutMotion) {
  Random random(4);
  for (int trial = 0; trial < 20; ++trial) {
    Scene scene(random);
    scene.motion = {};
    scene.calibration = {};
    const Reprojection moving = scene.Reproject();
    const Reprojection still(kCamera, scene.camera_from_world * scene.point_in_world);
    const PointMeasurement& measured = scene.measured;
    const Eigen::Matrix3d by_p = still.ByMovedPoint(measured);
    EXPECT_EQ(moving.Residual(measured), still.Residual(measured));
    EXPECT_EQ(moving.ByMovedPoint(measured), by_p);
    EXPECT_EQ(moving.ByMiddlePoint(by_p), by_p);
    EXPECT_EQ(moving.ByPose(by_p), still.ByPose(by_p));
  }
}

TEST(Reprojection, OfAnExactMeasurementIsZeroAndTheErrorIsTheCameras) {
  const Eigen::Vector3d point(0.3, -0.2, 1.5);
  const Eigen::Vector2d pixel = *kCamera.ProjectUndistorted(point);
  const Reprojection seen(kCamera, point);
  EXPECT_LT(seen.Residual({pixel, 1.5, 1, 100}).norm(), 1e-9);
  EXPECT_NEAR(seen.Residual({pixel + Eigen::Vector2d(3, 4), 1.5, 1, 100}).norm(),
              ReprojectionError_px(kCamera, point, pixel + Eigen::Vector2d(3, 4)),
              1e-9);
}

TEST(Reprojection, WhatIsBehindOrTooNearIsNotVisible) {
  EXPECT_FALSE(Reprojection(kCamera, {0, 0, -1}).IsVisible());
  EXPECT_FALSE(Reprojection(kCamera, {0, 0, 0.9 * Reprojection::kMinDepth_m}).IsVisible());
  EXPECT_TRUE(Reprojection(kCamera, {0, 0, Reprojection::kMinDepth_m}).IsVisible());
  EXPECT_EQ(ReprojectionError_px(kCamera, {0, 0, -1}, {0, 0}),
            std::numeric_limits<double>::infinity());
}

}  // namespace nightmap::reprojection_test
