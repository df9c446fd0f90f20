// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/wheel_edges.h"

#include <optional>

namespace nightmap {
namespace {

// The covariance of `motion` in the wheels' frame at its end, about the origin of that frame.
Matrix6d Covariance(const WheelNoise& noise, const WheelMotion& motion) {
  const double position_m = noise.PositionSigma_m(motion);
  Vector6d sigma;
  sigma << noise.plane_sigma_rad, noise.plane_sigma_rad, noise.HeadingSigma_rad(motion), position_m,
      position_m, noise.plane_sigma_m;
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

double WheelNoise::PositionSigma_m(const WheelMotion& motion) const {
  return position_sigma_floor_m + position_sigma_per_distance * motion.distance_m +
         position_sigma_m_per_rad * motion.turn_rad;
}

double WheelNoise::HeadingSigma_rad(const WheelMotion& motion) const {
  return heading_sigma_floor_rad + heading_sigma_rad_per_m * motion.distance_m +
         heading_sigma_per_turn * motion.turn_rad;
}

SensorEdges WheelEdges(const WheelNoise& noise,
                       const std::vector<FrameRecord>& frames,
                       const std::vector<RgbdCamera>& cameras,
                       const Signal& odometry) {
  const Rigid3 wheels_from_robot = odometry.robot_from_sensor.Inverse();
  const auto wheels_from_camera = [&](const FrameRecord& frame) {
    return wheels_from_robot *
           cameras.at(static_cast<std::size_t>(frame.camera_idx)).robot_from_camera;
  };
  Mounting mounting{odometry.robot_from_sensor, {}};
  for (const RgbdCamera& camera : cameras) {
    mounting.robot_from_camera.push_back(camera.robot_from_camera);
  }
  SensorEdges result{odometry.sensor_id, {}, mounting};
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const FrameRecord& a = frames[i - 1];
    const FrameRecord& b = frames[i];
    if (a.sequence_idx != b.sequence_idx) continue;
    const auto motion = MotionBetween(odometry.samples, noise.max_gap_s, a.time_ns, b.time_ns);
    if (!motion) continue;
    const Rigid3 camera_from_wheels = wheels_from_camera(b).Inverse();
    const Matrix6d adjoint = Adjoint(camera_from_wheels);
    result.edges.push_back(
        {EdgeKind::kOdometry,
         a.time_ns,
         b.time_ns,
         camera_from_wheels * motion->start_from_end.Inverse() * wheels_from_camera(a),
         adjoint * Covariance(noise, *motion) * adjoint.transpose()});
  }
  return result;
}

}  // namespace nightmap
