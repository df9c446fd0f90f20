// SPDX-License-Identifier: Apache-2.0
// Finds from the motion of a camera how a sensor that moves with it is mounted, how far its clock
// is off, and by how much it stretches the way (hand-eye calibration, AX = XB).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/graph/camera_runs.h"
#include "pipeline/graph/sensor_edges.h"

namespace nightmap {

// Unknowns: rotation (rad) and translation (m) of the mounting pose along the robot's axes, scale,
// time (s).
using CalibrationVector = Eigen::Matrix<double, 8, 1>;
constexpr int kScaleIdx = 6;
constexpr int kTimeIdx = 7;

// SensorCalibration says what to add to the site config, and how sure that is. The pose of a rig's
// cameras is not corrected: several cameras that agree with each other tell of the sensor's pose.
struct SensorCalibration {
  std::optional<int> camera_idx;  // the pose is robot_from_camera of it; none: robot_from_sensor
  Rigid3 given_pose;              // as the edges were made with
  // The pose's rotation is turned and its translation is shifted. The sensor measures 1 + scale
  // metres for one. Time is added to the times of the sensor.
  CalibrationVector value = CalibrationVector::Zero();
  CalibrationVector sigma = CalibrationVector::Zero();
  std::vector<bool> is_observable;  // by unknown; the value is 0 where the motion does not tell it
  int num_stretches = 0;            // compared motions

  Rigid3 CorrectedPose() const;
};

// Compares stretches of the sensor's odometry with the same motions of the camera: robust least
// squares from the given mounting, whose deviations are those of the residuals (median absolute
// deviation, each axis of the sensor for itself). `camera_runs` must not be made of the sensor's
// edges, or they hide its error. Weak priors (0.5 rad, 1 m, 5 %, 0.1 s) hold what the motion does
// not show: the height of all that drives on a floor, and all but a heading where nothing turns.
// None with fewer than 20 stretches, or when the mounting is not known. Deterministic; one thread.
std::optional<SensorCalibration> CalibrateSensor(const EdgeSigmaFloor& floor,
                                                 const std::vector<CameraRun>& camera_runs,
                                                 const SensorGraph& sensor);

}  // namespace nightmap
