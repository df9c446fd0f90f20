// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/synthesize_ceiling.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kBiasStream = 710;
constexpr std::uint64_t kWheelStream = 711;
constexpr std::uint64_t kFrameStream = 712;

std::int64_t TimeOf_ns(double time_s) { return kFirstCeilingFrame_ns + std::llround(time_s * 1e9); }

// About how far a picture of a low ceiling moves between two poses, px.
double Motion_px(const Camera& camera, const Rigid3& a, const Rigid3& b) {
  constexpr double kNearest_m = 1.75;
  const double shift_px = (b.translation - a.translation).norm() / kNearest_m * camera.fx;
  const Eigen::AngleAxisd turn((a.rotation.conjugate() * b.rotation).normalized());
  const Eigen::Vector3d turn_rad = turn.angle() * turn.axis();
  return shift_px + std::abs(turn_rad.z()) * std::hypot(camera.cx, camera.cy) +
         turn_rad.head<2>().norm() * camera.fx;
}

}  // namespace

WheelOptions DrawWheelBiases(const SynthesizeCeilingOptions& options) {
  WheelOptions wheels = options.wheels;
  Random random(options.NoiseSeed(), kBiasStream);
  wheels.scale_bias += options.scale_bias_sigma * random.Gaussian();
  wheels.heading_bias_rad_per_m += options.heading_bias_sigma_rad_per_m * random.Gaussian();
  return wheels;
}

WheelOdometry DriveWheels(const RobotDrive& drive,
                          const SynthesizeCeilingOptions& options,
                          const WheelOptions& wheels) {
  return {drive, wheels, Random(options.NoiseSeed(), kWheelStream).Next(), options.slip};
}

CeilingRecording PlanCeilingRecording(const SynthesizeCeilingOptions& options, int num_threads) {
  CeilingPlan plan =
      options.layout == "office"
          ? PlanCeilingOffice(options.seed)
          : PlanCeilingCorridor(options.blank_length_m, options.overlap_m, options.seed);
  RobotDrive drive = DriveCeilingLegs(plan.legs, options.route);
  if (options.duration_s > 0) drive = CutDrive(drive, options.duration_s);
  const UpwardMotion motion(drive, options.mount, options.NoiseSeed());
  const WheelOptions wheels = DrawWheelBiases(options);
  CeilingRecording recording{PaintCeilingWorld(std::move(plan), options.seed, num_threads),
                             motion,
                             wheels,
                             DriveWheels(drive, options, wheels),
                             {},
                             {},
                             {}};
  const auto num_frames =
      static_cast<std::size_t>(drive.Duration_s() * options.frame_rate_hz + 1e-6) + 1;
  for (std::size_t i = 0; i < num_frames; ++i) {
    const double time_s = static_cast<double>(i) / options.frame_rate_hz;
    recording.building_from_robot.push_back({TimeOf_ns(time_s), motion.RobotAt(time_s)});
    recording.building_from_camera.push_back({TimeOf_ns(time_s), motion.CameraAt(time_s)});
  }
  recording.gains =
      CeilingGains(recording.world, recording.building_from_camera, options, num_threads);
  return recording;
}

ColorImage RenderCeilingFrame(const SynthesizeCeilingOptions& options,
                              const CeilingRecording& recording,
                              std::size_t idx) {
  const Camera camera = options.Pinhole();
  const double time_s = static_cast<double>(idx) / options.frame_rate_hz;
  const double half_s = options.exposure_s / 2;
  const double motion_px = Motion_px(camera,
                                     recording.motion.CameraAt(time_s - half_s),
                                     recording.motion.CameraAt(time_s + half_s));
  const int num_times = motion_px <= 0.5 ? 1 : motion_px <= 2 ? 2 : 4;
  std::vector<Rigid3> poses;
  for (int i = 0; i < num_times; ++i) {
    const double share = (i + 0.5) / num_times - 0.5;
    poses.push_back(recording.motion.CameraAt(time_s + share * options.exposure_s));
  }
  const SensorNoise noise{recording.gains[idx], options.vignetting, options.color_noise_levels};
  const std::uint64_t seed = Random(options.NoiseSeed(), kFrameStream, idx).Next();
  return ExposeCeiling(RenderCeiling(recording.world, camera, poses), noise, seed);
}

void RunSynthesizeCeiling(const SynthesizeCeilingOptions& options,
                          const CeilingRecording& recording,
                          const CeilingFrameSink& sink,
                          Progress& progress,
                          int num_threads) {
  const std::size_t num_frames = recording.building_from_camera.size();
  progress.Start(num_frames);
  ParallelFor(num_frames, num_threads, [&](std::size_t i) {
    sink(i, RenderCeilingFrame(options, recording, i));
    progress.Advance();
  });
  progress.Finish();
}

nlohmann::json DescribeCeilingRecording(const CeilingRecording& recording) {
  const std::vector<StampedPose>& poses = recording.building_from_robot;
  double length_m = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    length_m += (poses[i].pose.translation - poses[i - 1].pose.translation).norm();
  }
  const Rigid3 moved = poses.front().pose.Inverse() * poses.back().pose;
  const Eigen::Vector2d drift_m =
      recording.odometry.Samples().back().head<2>() - moved.translation.head<2>();
  nlohmann::json report;
  report["num_frames"] = poses.size();
  report["num_odometry_samples"] = recording.odometry.Samples().size();
  report["num_rectangles"] = recording.world.plan.rects.size();
  report["num_fittings"] = recording.world.plan.fittings.size();
  report["route_length_m"] = length_m;
  report["duration_s"] = recording.motion.Drive().Duration_s();
  report["odometry_drift_m"] = drift_m.norm();
  report["wheel_scale_bias"] = recording.wheels.scale_bias;
  report["wheel_heading_bias_rad_per_m"] = recording.wheels.heading_bias_rad_per_m;
  report["mount_roll_rad"] = recording.motion.MountTilt_rad()[0];
  report["mount_pitch_rad"] = recording.motion.MountTilt_rad()[1];
  return report;
}

}  // namespace nightmap
