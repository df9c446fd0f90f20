// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/accelerometer.h"

#include <gtest/gtest.h>

#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "tests/stages/dense/map_frame/level_camera.h"
#include "tests/test_data.h"

namespace nightmap::accelerometer_test {

// A camera that turns on its side while it walks, and what its accelerometer measures at 50 Hz.
struct Walk {
  std::vector<StampedPose> keyframes;
  std::vector<AccelerometerSample> samples;
};

Walk RollingWalk() {
  constexpr std::int64_t kStep_ns = 20'000'000;
  Walk walk;
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Eigen::AngleAxisd roll(2 * std::numbers::pi * i / 200, Eigen::Vector3d::UnitZ());
    Rigid3 pose = Looking(0.01 * i, 1.2, 0.2);
    pose.rotation = pose.rotation * Eigen::Quaterniond(roll);
    const Eigen::Vector3d motion(random.Gaussian(), random.Gaussian(), random.Gaussian());
    walk.samples.push_back(
        {i * kStep_ns, pose.rotation.conjugate() * Eigen::Vector3d(0, 0, 9.8) + 0.5 * motion});
    if (i % 10 == 0) walk.keyframes.push_back({i * kStep_ns, pose});
  }
  return walk;
}

TEST(UpFromAccelerometer, FollowsTheAttitudeOfTheCamera) {
  const Walk walk = RollingWalk();
  EXPECT_GT(UpFromAccelerometer(walk.samples, walk.keyframes).z(), 0.999);
}

TEST(UpFromAccelerometer, TakesSamplesNearKeyframesOnly) {
  const std::vector<StampedPose> keyframes{{1'000'000'000, Rigid3()}};
  const std::vector<AccelerometerSample> samples{{899'999'999, {9.8, 0, 0}},
                                                 {900'000'000, {0, 0, 9.8}},
                                                 {1'100'000'000, {0, 0, 9.8}},
                                                 {1'100'000'001, {9.8, 0, 0}}};
  EXPECT_EQ(UpFromAccelerometer(samples, keyframes), Eigen::Vector3d(0, 0, 1));
}

TEST(UpFromAccelerometer, RefusesWhatShowsNoGravity) {
  Walk walk = RollingWalk();
  const auto samples = walk.samples;
  // The same for a camera that does not roll: as recorded in axes that are not the camera's.
  for (StampedPose& keyframe : walk.keyframes) keyframe.pose = Rigid3();
  NIGHTMAP_EXPECT_ERROR(
      DataError, UpFromAccelerometer(samples, walk.keyframes), "acceleration: the mean over");
  for (StampedPose& keyframe : walk.keyframes) keyframe.time_ns += 60'000'000'000;
  NIGHTMAP_EXPECT_ERROR(
      DataError, UpFromAccelerometer(samples, walk.keyframes), "acceleration: no sample");
}

}  // namespace nightmap::accelerometer_test
