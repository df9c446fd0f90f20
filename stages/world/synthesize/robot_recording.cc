// SPDX-License-Identifier: Apache-2.0
#include "stages/world/synthesize/robot_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/world/laser_scanner.h"
#include "pipeline/world/wheel_odometry.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kWalkerSeedStream = 603;
constexpr std::uint64_t kScanSeedStream = 604;
constexpr std::uint64_t kWheelSeedStream = 605;

std::uint64_t SeedOf(const SynthesizeOptions& options, std::uint64_t stream, std::size_t idx = 0) {
  const auto first_idx = static_cast<std::uint64_t>(options.recording) << 32;
  return Random(static_cast<std::uint64_t>(options.building.seed), stream, first_idx + idx).Next();
}

std::int64_t TimeOf_ns(double time_s) { return kFirstFrame_ns + std::llround(time_s * 1e9); }

std::vector<WheelSample> WheelSamples(const WheelOdometry& odometry) {
  std::vector<WheelSample> samples;
  const std::vector<Eigen::Vector3d>& poses = odometry.Samples();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    WheelSample sample{TimeOf_ns(odometry.TimeOf_s(i)), poses[i], 0, 0};
    if (i > 0) {
      const Eigen::Vector3d motion = poses[i] - poses[i - 1];
      const double heading_rad = poses[i - 1][2];
      const double forward_m =
          motion[0] * std::cos(heading_rad) + motion[1] * std::sin(heading_rad);
      const double step_s = odometry.TimeOf_s(1);
      sample.speed_m_per_s = forward_m / step_s;
      sample.turn_rad_per_s = motion[2] / step_s;
    }
    samples.push_back(sample);
  }
  return samples;
}

std::string PoseText(const Eigen::Vector3d& pose) {
  return fmt::format("{:.6f} {:.6f} {:.6f}", pose[0], pose[1], pose[2]);
}

std::string TimeText(std::int64_t time_ns) {
  const std::string time = TimeToString(time_ns);
  return time + " robot " + time;
}

std::string ScanLine(const RobotScan& scan) {
  std::string line = fmt::format("FLASER {}", scan.ranges_m.size());
  for (const float range_m : scan.ranges_m) line += fmt::format(" {:.3f}", range_m);
  const std::string pose = PoseText(scan.odometry);
  return line + fmt::format(" {} {} {}\n", pose, pose, TimeText(scan.time_ns));
}

std::string WheelLine(const WheelSample& sample) {
  return fmt::format("ODOM {} {:.6f} {:.6f} 0 {}\n",
                     PoseText(sample.odometry),
                     sample.speed_m_per_s,
                     sample.turn_rad_per_s,
                     TimeText(sample.time_ns));
}

// The robot's poses at the times of the scans and, with an upward camera, of all pictures.
std::vector<StampedPose> TruePoses(const std::vector<RobotScan>& scans,
                                   const SynthesizePlan& plan,
                                   const RobotDrive& drive) {
  std::map<std::int64_t, Rigid3> poses;
  for (const RobotScan& scan : scans) poses.emplace(scan.time_ns, RobotPose(scan.robot));
  const auto add = [&](const StampedPose& picture) {
    const double time_s = static_cast<double>(picture.time_ns - kFirstFrame_ns) * 1e-9;
    poses.emplace(picture.time_ns, RobotPose(drive.At(time_s)));
  };
  if (!plan.upward.empty()) std::for_each(plan.frames.begin(), plan.frames.end(), add);
  std::for_each(plan.upward.begin(), plan.upward.end(), add);
  std::vector<StampedPose> list;
  for (const auto& [time_ns, pose] : poses) list.push_back({time_ns, pose});
  return list;
}

}  // namespace

RobotRecording RecordRobot(const SynthesizeOptions& options,
                           const SynthesizePlan& plan,
                           int num_threads) {
  const ScannerOptions& scanner_options = options.scanner;
  if (scanner_options.duration_s * scanner_options.rate_hz > 1) {
    throw UsageError(
        "a scan of scan_duration_s = {} is not over when the next one begins: lower it, or "
        "scan_rate_hz = {}",
        scanner_options.duration_s,
        scanner_options.rate_hz);
  }
  const SyntheticWorld& world = plan.world;
  const RobotDrive drive = PlanDrive(world.layout, options.route, options.frame_rate_hz);
  const WheelOdometry odometry(drive, options.wheels, SeedOf(options, kWheelSeedStream));
  const auto seed = static_cast<std::uint64_t>(options.building.seed);
  const LaserScanner scanner(
      world,
      PlanWalkers(world, drive, scanner_options.num_walkers, SeedOf(options, kWalkerSeedStream)),
      scanner_options,
      seed);
  RobotRecording recording;
  recording.max_range_m = static_cast<float>(scanner_options.max_range_m);
  recording.wheels = WheelSamples(odometry);
  const double last_s =
      odometry.Duration_s() - scanner_options.duration_s - scanner_options.start_s;
  if (last_s < 0) {
    throw UsageError("the drive is shorter than scan_start_s + scan_duration_s: raise num_frames");
  }
  recording.scans.resize(static_cast<std::size_t>(last_s * scanner_options.rate_hz) + 1);
  ParallelFor(recording.scans.size(), num_threads, [&](std::size_t i) {
    const double time_s =
        scanner_options.start_s + static_cast<double>(i) / scanner_options.rate_hz;
    recording.scans[i] = {TimeOf_ns(time_s),
                          drive.At(time_s),
                          odometry.At(time_s),
                          scanner.Scan(drive, time_s, SeedOf(options, kScanSeedStream, i))};
  });
  recording.truth = TruePoses(recording.scans, plan, drive);
  return recording;
}

nlohmann::json DescribeRobot(const RobotRecording& recording) {
  std::size_t num_beams = 0;
  std::size_t num_hits = 0;
  for (const RobotScan& scan : recording.scans) {
    num_beams += scan.ranges_m.size();
    num_hits += static_cast<std::size_t>(std::ranges::count_if(
        scan.ranges_m, [&](float range_m) { return range_m < recording.max_range_m; }));
  }
  const RobotScan& first = recording.scans.front();
  const RobotScan& last = recording.scans.back();
  const Rigid3 moved = RobotPose(first.robot).Inverse() * RobotPose(last.robot);
  const Eigen::Vector2d drift = last.odometry.head<2>() - moved.translation.head<2>();
  nlohmann::json report;
  report["num_scans"] = recording.scans.size();
  report["num_odometry_samples"] = recording.wheels.size();
  report["beam_hit_ratio"] = static_cast<double>(num_hits) / static_cast<double>(num_beams);
  report["odometry_drift_m"] = drift.norm();
  return report;
}

std::string CarmenLog(const RobotRecording& recording) {
  std::string log =
      "# FLASER n ranges x y theta odom_x odom_y odom_theta time host logger_time\n"
      "# ODOM x y theta tv rv acceleration time host logger_time\n";
  std::size_t next = 0;
  for (const WheelSample& sample : recording.wheels) {
    while (next < recording.scans.size() && recording.scans[next].time_ns < sample.time_ns) {
      log += ScanLine(recording.scans[next++]);
    }
    log += WheelLine(sample);
  }
  while (next < recording.scans.size()) log += ScanLine(recording.scans[next++]);
  return log;
}

std::string RobotTruth(const RobotRecording& recording) {
  return TrajectoryToTum(recording.truth, "building_from_robot; time_s tx ty tz qx qy qz qw");
}

}  // namespace nightmap
