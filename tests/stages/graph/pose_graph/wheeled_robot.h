// SPDX-License-Identifier: Apache-2.0
// A robot that drives through the corridors of a made-up building: what its camera and its wheels
// measure, with noise.
#pragma once

#include <numbers>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/recording/wheel_edges.h"
#include "stages/graph/pose_graph/pose_graph.h"

namespace nightmap {

// A robot's camera may sit, and the clock of its wheels may run, otherwise than the site config
// says.
struct WheeledRobot {
  Rigid3 robot_from_camera;  // the true one
  Rigid3 given_pose;         // the one of the site config
  double clock_late_s = 0;   // of the wheels
  std::uint64_t seed = 1;
  bool turns = true;
};

// Looks ahead and `pitch_rad` down.
inline Rigid3 CameraAhead(double pitch_rad, const Eigen::Vector3d& position_m) {
  const Eigen::Quaterniond ahead(0.5, -0.5, 0.5, -0.5);
  return {ahead * Eigen::Quaterniond(Eigen::AngleAxisd(-pitch_rad, Eigen::Vector3d::UnitX())),
          position_m};
}

class WheeledDrive {
 public:
  explicit WheeledDrive(const WheeledRobot& robot) : robot_(robot), random_(robot.seed) {
    wheels_.kind = SignalKind::kOdometry;
    wheels_.sensor_id = "wheels";
    // Corridors, corners to either side, and turns on the spot: 2 minutes.
    for (int lap = 0; lap < 3; ++lap) {
      for (const double turn : {1.0, 1.0, -1.0, 1.0, 1.0, 1.0}) {
        Drive(0.6, 0, 4.2);
        Drive(0.35, 0.8 * turn, 1.96);
      }
      Drive(0.5, -0.1, 3);
      Drive(0, 0.7, 2);
    }
    MakeCamera();
  }

  // pose_graph reads this.
  PoseGraphInput Input() const {
    std::vector<RgbdCamera> cameras(1);
    cameras[0].robot_from_camera = robot_.given_pose;
    PoseGraphInput input;
    input.frames = frames_;
    input.odometry = {shard_};
    input.edges = {WheelEdges({}, frames_, cameras, wheels_)};
    return input;
  }

 private:
  static constexpr std::int64_t kSample_ns = 20'000'000;
  static constexpr int kSamplesPerFrame = 5;
  static constexpr int kFramesPerKeyframe = 3;

  void Drive(double speed_m_per_s, double turn_rad_per_s, double duration_s) {
    if (!robot_.turns) turn_rad_per_s = 0;
    const double sample_s = 1e-9 * static_cast<double>(kSample_ns);
    for (double t = 0; t < duration_s; t += sample_s) {
      speed_ += 0.1 * (speed_m_per_s - speed_);  // no robot starts to turn at once
      turn_ += 0.1 * (turn_rad_per_s - turn_);
      AddSample(speed_ * sample_s, turn_ * sample_s);
    }
  }

  // The wheels measure half a percent too much, with noise of 2 cm and 1 degree after a metre.
  void AddSample(double distance_m, double turn_rad) {
    true_.push_back(true_.empty() ? Eigen::Vector3d(0, 0, 0)
                                  : Moved(true_.back(), distance_m, turn_rad));
    const double noise = std::sqrt(distance_m);
    const double measured_m = 1.005 * distance_m + 0.02 * noise * random_.Gaussian();
    const double measured_rad = turn_rad + std::numbers::pi / 180 * noise * random_.Gaussian();
    const auto time_ns = static_cast<std::int64_t>(true_.size() - 1) * kSample_ns;
    const Eigen::Vector3d value =
        wheels_.samples.empty() ? Eigen::Vector3d(0, 0, 0)
                                : Moved(wheels_.samples.back().value, measured_m, measured_rad);
    wheels_.samples.push_back({time_ns + std::llround(1e9 * robot_.clock_late_s), value, {}});
  }

  // x, y, heading after an arc.
  static Eigen::Vector3d Moved(const Eigen::Vector3d& from, double distance_m, double turn_rad) {
    const double heading = from.z() + turn_rad / 2;
    return from + Eigen::Vector3d(
                      distance_m * std::cos(heading), distance_m * std::sin(heading), turn_rad);
  }

  Rigid3 TrueCamera(std::size_t sample) const {
    const Eigen::Vector3d& robot = true_[sample];
    return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(robot.z(), Eigen::Vector3d::UnitZ())),
                  {robot.x(), robot.y(), 0}} *
           robot_.robot_from_camera;
  }

  // 5 mm and 0.1 degrees from keyframe to keyframe.
  Rigid3 CameraNoise() {
    Vector6d step;
    for (double& value : step) value = random_.Gaussian() / std::sqrt(kFramesPerKeyframe);
    step.head<3>() *= 0.1 * std::numbers::pi / 180;
    step.tail<3>() *= 0.005;
    return PerturbLeft(step, {});
  }

  void MakeCamera() {
    Matrix6d covariance = Matrix6d::Zero();
    covariance.diagonal() << Eigen::Vector3d::Constant(3e-6), Eigen::Vector3d::Constant(2.5e-5);
    Rigid3 pose;
    for (std::size_t i = 0; i * kSamplesPerFrame < true_.size(); ++i) {
      const std::size_t sample = i * kSamplesPerFrame;
      if (i > 0) {
        pose = pose * TrueCamera(sample - kSamplesPerFrame).Inverse() * TrueCamera(sample) *
               CameraNoise();
      }
      const int idx = static_cast<int>(i);
      const bool is_keyframe = idx % kFramesPerKeyframe == 0;
      frames_.push_back({idx, static_cast<std::int64_t>(sample) * kSample_ns, 0, 0, {}, {}, {}});
      shard_.frames.push_back({idx, pose, TrackingState::kTracked, is_keyframe});
      if (!is_keyframe || idx == 0) continue;
      const int before = idx - kFramesPerKeyframe;
      const Rigid3& from = shard_.frames[static_cast<std::size_t>(before)].shard_from_camera;
      shard_.edges.push_back({before, idx, pose.Inverse() * from, covariance, false});
    }
  }

  WheeledRobot robot_;
  Random random_;
  double speed_ = 0;
  double turn_ = 0;
  std::vector<Eigen::Vector3d> true_;  // x, y, heading by sample
  Signal wheels_;
  std::vector<FrameRecord> frames_;
  OdometryShard shard_;
};

}  // namespace nightmap
