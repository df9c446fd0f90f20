// SPDX-License-Identifier: Apache-2.0
// Up direction from an accelerometer on the robot.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

// One sample of an accelerometer, along the axes of the robot.
struct AccelerometerSample {
  std::int64_t time_ns = 0;
  Eigen::Vector3d acceleration_m_per_s2 = Eigen::Vector3d::Zero();
};

// Samples of the first sensor that measures acceleration, rotated into the axes of the robot; none
// when there is no such sensor. Throws DataError naming file and field.
std::vector<AccelerometerSample> ReadAcceleration(const std::filesystem::path& path);

// Up in the given frame, of unit length. At rest an accelerometer measures up, and the acceleration
// of the camera itself cancels in the mean. Each keyframe (its time and given_from_robot) rotates
// the mean of the samples within 0.1 s of it. `samples` ascend in time. Throws DataError when no
// keyframe has a sample or the mean is far from gravity.
Eigen::Vector3d UpFromAccelerometer(const std::vector<AccelerometerSample>& samples,
                                    const std::vector<StampedPose>& keyframes);

}  // namespace nightmap
