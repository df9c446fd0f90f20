// SPDX-License-Identifier: Apache-2.0
// Records of the robot's laser and wheels on the drive of a SynthesizePlan, with its true poses.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/world/route.h"
#include "stages/world/synthesize/synthesize.h"

namespace nightmap {

// The files in the folder of the recording.
inline constexpr const char* kRobotLog = "robot.log";
inline constexpr const char* kRobotTruth = "robot_groundtruth.txt";

struct RobotScan {
  std::int64_t time_ns = 0;                            // of the first beam
  RoutePoint robot;                                    // true pose at that time
  Eigen::Vector3d odometry = Eigen::Vector3d::Zero();  // x m, y m, heading rad at that time
  std::vector<float> ranges_m;
};

struct WheelSample {
  std::int64_t time_ns = 0;
  Eigen::Vector3d odometry = Eigen::Vector3d::Zero();
  double speed_m_per_s = 0;  // since the previous sample, forward
  double turn_rad_per_s = 0;
};

struct RobotRecording {
  float max_range_m = 0;  // range of a beam that returned nothing
  std::vector<RobotScan> scans;
  std::vector<WheelSample> wheels;
  std::vector<StampedPose> truth;  // building_from_robot, in the order of time
};

// Records from the time of the first frame until that of the last. The truth is known at the time
// of each scan; with an upward camera also at that of each frame and upward picture. Throws
// UsageError when the options contradict each other. Does not depend on num_threads.
RobotRecording RecordRobot(const SynthesizeOptions& options,
                           const SynthesizePlan& plan,
                           int num_threads);

// Counts and figures for report.json, among them the drift of the odometry: the distance at the
// last scan between its pose and the true one, both in the first scan's.
nlohmann::json DescribeRobot(const RobotRecording& recording);

// A log in the format of CARMEN, in the order of time:
//   FLASER n ranges x y theta odom_x odom_y odom_theta time host logger_time
//   ODOM x y theta tv rv acceleration time host logger_time
// Both poses of a FLASER line are the odometry, which is linear between the ODOM lines. Metres,
// rad, seconds; ranges in mm steps.
std::string CarmenLog(const RobotRecording& recording);

// The truth in the TUM format.
std::string RobotTruth(const RobotRecording& recording);

}  // namespace nightmap
