// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/sensor_calibration.h"

#include <cstdio>

#include "pipeline/base/median.h"
#include "stages/graph/pose_graph/pose_graph_output.h"
#include "tests/stages/graph/pose_graph/circle_scene.h"
#include "tests/stages/graph/pose_graph/wheeled_robot.h"

namespace nightmap::sensor_calibration_test {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kNumSeeds = 5;

// A camera in the middle, and one that is ahead, a metre high and looks down.
std::vector<Rigid3> CameraPoses() {
  return {CameraAhead(0, {0, 0, 0}), CameraAhead(10 * kDegree, {0.2, 0, 1})};
}

// The error is to be found as its correction.
Rigid3 WithError(const Rigid3& pose, const Eigen::Vector3d& shift_m, double turn_rad) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(-turn_rad, Eigen::Vector3d::UnitZ()));
  return {turn * pose.rotation, pose.translation - shift_m};
}

SensorRecord RecordOf(const WheeledRobot& robot) {
  const PoseGraphResult result = Optimize(WheeledDrive(robot).Input());
  EXPECT_EQ(result.sensors.size(), 1U);
  EXPECT_TRUE(result.sensors.at(0).calibration.has_value());
  return result.sensors.at(0);
}

TEST(SensorCalibration, ARightMountingAndClockAreNotWarnedOf) {
  for (const Rigid3& pose : CameraPoses()) {
    for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
      const SensorRecord record = RecordOf({pose, pose, 0, seed});
      EXPECT_THAT(record.warnings, testing::IsEmpty()) << seed;
      EXPECT_NEAR(record.calibration->value[kScaleIdx], 0.005, 0.01) << seed;
    }
  }
}

TEST(SensorCalibration, AWrongMountingIsFoundAndTheNewPoseIsRight) {
  const Eigen::Vector3d shift_m(0.04, -0.03, 0);
  for (const Rigid3& pose : CameraPoses()) {
    std::vector<double> errors_m, errors_rad;
    for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
      const SensorRecord record = RecordOf({pose, WithError(pose, shift_m, 3 * kDegree), 0, seed});
      ASSERT_EQ(record.warnings.size(), 1U) << seed;
      EXPECT_THAT(record.warnings[0], testing::HasSubstr("write robot_from_camera = ["));
      const Rigid3 corrected = record.calibration->CorrectedPose();
      errors_m.push_back((corrected.translation - pose.translation).norm());
      errors_rad.push_back(AngleBetween_rad(corrected, pose));
      EXPECT_THAT(RecordOf({pose, corrected, 0, seed}).warnings, testing::IsEmpty()) << seed;
    }
    std::printf(
        "mounting: %.1f mm, %.2f deg\n", 1e3 * Median(errors_m), Median(errors_rad) / kDegree);
    EXPECT_LT(Median(errors_m), 0.01);
    EXPECT_LT(Median(errors_rad), 0.5 * kDegree);
  }
}

TEST(SensorCalibration, AWrongClockIsFoundAndTheOffsetPutsItRight) {
  for (const double late_s : {0.05, -0.05}) {
    for (const Rigid3& pose : CameraPoses()) {
      std::vector<double> errors_s;
      for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
        const SensorRecord record = RecordOf({pose, pose, late_s, seed});
        ASSERT_EQ(record.warnings.size(), 1U) << seed << record.warnings.size();
        EXPECT_THAT(record.warnings[0],
                    testing::HasSubstr(late_s > 0 ? "late: add -0.0" : "early: add 0.0"));
        const double offset_s = record.calibration->value[kTimeIdx];  // is added to all times
        errors_s.push_back(std::abs(offset_s + late_s));
        EXPECT_THAT(RecordOf({pose, pose, late_s + offset_s, seed}).warnings, testing::IsEmpty());
      }
      std::printf("clock: %.1f ms\n", 1e3 * Median(errors_s));
      EXPECT_LT(Median(errors_s), 0.01);
    }
  }
}

TEST(SensorCalibration, WhatTheMotionDoesNotShowIsNotTold) {
  const Rigid3 pose = CameraPoses()[1];
  const SensorRecord plane = RecordOf({pose, WithError(pose, {0, 0, 0.3}, 0), 0, 1});
  EXPECT_FALSE(plane.calibration->is_observable[5]);
  EXPECT_THAT(plane.warnings, testing::IsEmpty());
  const SensorRecord straight =
      RecordOf({pose, WithError(pose, {0.1, 0.1, 0}, 3 * kDegree), 0, 1, false});
  EXPECT_FALSE(straight.calibration->is_observable[3]);
  EXPECT_FALSE(straight.calibration->is_observable[4]);
  EXPECT_FALSE(straight.calibration->is_observable[0]);
  EXPECT_NEAR(straight.calibration->value[2], 3 * kDegree, 0.5 * kDegree);
  EXPECT_THAT(straight.warnings, testing::SizeIs(1));
}

TEST(SensorCalibration, TheReportHasWarningsAndValues) {
  const Rigid3 pose = CameraPoses()[1];
  PoseGraphInput input =
      WheeledDrive({pose, WithError(pose, {0.05, 0, 0}, 3 * kDegree), 0, 1}).Input();
  const PoseGraphResult result = Optimize(input);
  const nlohmann::json sensor = Summarize(input, result).at("sensors").at(0);
  EXPECT_EQ(sensor.at("warnings").size(), 1U);
  const nlohmann::json& calibration = sensor.at("calibration");
  EXPECT_EQ(calibration.at("corrects"), "robot_from_camera");
  EXPECT_NEAR(calibration.at("value").at("x_m"), 0.05, 0.02);
  EXPECT_TRUE(calibration.at("value").at("z_m").is_null());
  input.edges[0].mounting.reset();
  EXPECT_FALSE(Optimize(input).sensors.at(0).calibration.has_value());
}

// How far the end of the drive, seen from its start, is from where the right edges put it.
double EndError_m(const PoseGraphOptions& options, const WheeledRobot& robot) {
  WheeledRobot right = robot;
  right.given_pose = robot.robot_from_camera;
  right.clock_late_s = 0;
  const auto end = [&](const WheeledRobot& of) {
    return Optimize(WheeledDrive(of).Input(), options).graph_from_camera.back().translation;
  };
  return (end(robot) - end(right)).norm();
}

TEST(SensorCalibration, CorrectedEdgesGiveTheTrajectoryOfTheRightOnes) {
  PoseGraphOptions corrects;
  corrects.calibrate_sensors = true;
  const Rigid3 pose = CameraPoses()[1];
  const WheeledRobot turned{pose, WithError(pose, {0.04, -0.03, 0}, 3 * kDegree), 0, 1};
  EXPECT_LT(EndError_m(corrects, turned), 0.5 * EndError_m({}, turned));
}

// A clock moves the end of the way little, but the edges disagree with the camera at each corner.
TEST(SensorCalibration, CorrectedTimesAgreeWithTheCameraBetter) {
  PoseGraphOptions corrects;
  corrects.calibrate_sensors = true;
  const Rigid3 pose = CameraPoses()[1];
  const auto residual = [&](const PoseGraphOptions& options, double late_s) {
    const PoseGraphInput input = WheeledDrive({pose, pose, late_s, 1}).Input();
    return Optimize(input, options).sensors.at(0).median_residual;
  };
  const double right = residual({}, 0);
  const double late = residual({}, 0.1);
  EXPECT_GT(late, right);
  EXPECT_LT(residual(corrects, 0.1) - right, 0.3 * (late - right));
}

TEST(SensorCalibration, AMountingWithoutACameraOfTheFramesIsRefused) {
  PoseGraphInput input = WheeledDrive({}).Input();
  input.frames.back().camera_idx = 1;
  NIGHTMAP_EXPECT_ERROR(
      DataError, Optimize(input), "robot_from_camera of 1 cameras, but the frames are of 2");
}

}  // namespace nightmap::sensor_calibration_test
