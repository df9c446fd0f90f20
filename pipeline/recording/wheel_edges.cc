// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/wheel_edges.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>

namespace nightmap {
namespace {

// The wheels' way from one moment to a later one.
struct WheelMotion {
  Rigid3 start_from_end;  // in the plane
  double distance_m = 0;  // along the way
  double turn_rad = 0;    // of all turns, left or right
};

double Sinc(double angle_rad) {
  return std::abs(angle_rad) < 1e-6 ? 1 : std::sin(angle_rad) / angle_rad;
}

// From one sample to the next, along an arc.
class Step {
 public:
  Step(const SignalSample& start, const SignalSample& end)
      : turn_rad_(std::remainder(end.value.z() - start.value.z(), 2 * std::numbers::pi)),
        chord_m_(Eigen::Rotation2Dd(-start.value.z()) *
                 (end.value.head<2>() - start.value.head<2>())) {}

  // Over a share of the time. On an arc it does not matter which.
  WheelMotion Part(double ratio) const {
    const double turn_rad = ratio * turn_rad_;
    const double arc_m = ratio / Sinc(turn_rad_ / 2);  // per metre of the whole chord
    const Eigen::Vector2d chord_m =
        arc_m * Sinc(turn_rad / 2) * (Eigen::Rotation2Dd((turn_rad - turn_rad_) / 2) * chord_m_);
    return {{Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ())),
             {chord_m.x(), chord_m.y(), 0}},
            arc_m * chord_m_.norm(),
            std::abs(turn_rad)};
  }

 private:
  double turn_rad_;          // in [-pi, pi]
  Eigen::Vector2d chord_m_;  // in the wheels' frame at the start
};

WheelMotion operator*(const WheelMotion& a, const WheelMotion& b) {
  return {
      a.start_from_end * b.start_from_end, a.distance_m + b.distance_m, a.turn_rad + b.turn_rad};
}

// None: not all of the way was sampled.
std::optional<WheelMotion> MotionBetween(const std::vector<SignalSample>& samples,
                                         double max_gap_s,
                                         std::int64_t start_ns,
                                         std::int64_t end_ns) {
  if (samples.empty() || start_ns < samples.front().time_ns || end_ns > samples.back().time_ns) {
    return std::nullopt;
  }
  WheelMotion motion;
  auto next = std::ranges::upper_bound(samples, start_ns, {}, &SignalSample::time_ns);
  for (std::int64_t time_ns = start_ns; time_ns < end_ns; ++next) {
    const SignalSample& before = *std::prev(next);
    const auto step_ns = static_cast<double>(next->time_ns - before.time_ns);
    if (step_ns > 1e9 * max_gap_s) return std::nullopt;
    const std::int64_t until_ns = std::min(end_ns, next->time_ns);
    motion = motion * Step(before, *next).Part(static_cast<double>(until_ns - time_ns) / step_ns);
    time_ns = until_ns;
  }
  return motion;
}

// The covariance of `motion` in the wheels' frame at its end, about the origin of that frame.
Matrix6d Covariance(const WheelNoise& noise, const WheelMotion& motion) {
  const double position_m = noise.position_sigma_floor_m +
                            noise.position_sigma_per_distance * motion.distance_m +
                            noise.position_sigma_m_per_rad * motion.turn_rad;
  const double heading_rad = noise.heading_sigma_floor_rad +
                             noise.heading_sigma_rad_per_m * motion.distance_m +
                             noise.heading_sigma_per_turn * motion.turn_rad;
  Vector6d sigma;
  sigma << noise.plane_sigma_rad, noise.plane_sigma_rad, heading_rad, position_m, position_m,
      noise.plane_sigma_m;
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

void WheelNoise::Register(OptionList& list) {
  const Range sigma(1e-6, 10), growth(0, 10);
  list.Add("position_sigma_floor_m",
           &position_sigma_floor_m,
           sigma,
           "standard deviation of x and y from frame to frame");
  list.Add("position_sigma_per_distance",
           &position_sigma_per_distance,
           growth,
           "added to it, in metres per metre driven");
  list.Add("position_sigma_m_per_rad",
           &position_sigma_m_per_rad,
           growth,
           "added to it per radian turned");
  list.Add("heading_sigma_floor_rad",
           &heading_sigma_floor_rad,
           sigma,
           "standard deviation of the heading from frame to frame");
  list.Add(
      "heading_sigma_rad_per_m", &heading_sigma_rad_per_m, growth, "added to it per metre driven");
  list.Add("heading_sigma_per_turn",
           &heading_sigma_per_turn,
           growth,
           "added to it, in radians per radian turned");
  list.Add("plane_sigma_m",
           &plane_sigma_m,
           sigma,
           "standard deviation of the height from frame to frame");
  list.Add("plane_sigma_rad",
           &plane_sigma_rad,
           sigma,
           "standard deviation of roll and pitch from frame to frame");
  list.Add(
      "max_gap_s", &max_gap_s, Range(0.001, 60), "an edge spans no longer gap between samples");
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
  SensorEdges result{odometry.sensor_id, {}};
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
