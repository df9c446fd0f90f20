// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/ceiling_ekf.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "pipeline/base/input_error.h"
#include "pipeline/ceiling/planar_pose.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/wheel_motion.h"
#include "stages/ceiling/ceiling_ekf/submaps.h"

namespace nightmap {
namespace {

// Distance from the anchor at which the robot's place becomes the next one.
constexpr double kAnchorDistance_m = 3;
// Way between two visits of a place that close a loop, at least.
constexpr double kMinLoopPath_m = 8;

// Motion of the robot between frames; by constant speed where the wheels say nothing.
class Motions {
 public:
  Motions(const Signal& wheels, double max_gap_s) : wheels_(wheels), max_gap_s_(max_gap_s) {}

  ControlInput Between(std::int64_t start_ns, std::int64_t end_ns) {
    const double time_s = static_cast<double>(end_ns - start_ns) * 1e-9;
    const auto motion = MotionBetween(wheels_.samples, max_gap_s_, start_ns, end_ns);
    ControlInput input;
    if (motion) {
      // The motion is that of the wheels' frame, and the robot's frame moves with it.
      const Rigid3 robot_from_wheels = wheels_.robot_from_sensor;
      input.before_from_after =
          ToRigid2(robot_from_wheels * motion->start_from_end * robot_from_wheels.Inverse());
      input.distance_m = motion->distance_m;
      input.turn_rad = motion->turn_rad;
      speed_m_per_s_ = input.before_from_after.translation / time_s;
      turn_rad_per_s_ = input.before_from_after.heading_rad / time_s;
    } else {
      input.before_from_after = {turn_rad_per_s_ * time_s, speed_m_per_s_ * time_s};
      input.unknown_time_s = time_s;
    }
    return input;
  }

 private:
  const Signal& wheels_;
  double max_gap_s_;
  Eigen::Vector2d speed_m_per_s_ = Eigen::Vector2d::Zero();
  double turn_rad_per_s_ = 0;
};

// An anchor is left after so many times its distance, by a robot that goes in circles.
constexpr double kMaxWay = 4;

// A frame as seen from the anchor that was active.
struct Step {
  CeilingFrame frame;
  int anchor = 0;
  Rigid2 anchor_from_robot;
};

CeilingFrame Describe(const TrackedFrame& tracked,
                      const ObservedFrame& observed,
                      const ControlInput& motion,
                      const CeilingFilter& filter) {
  CeilingFrame frame;
  frame.time_ns = tracked.time_ns;
  frame.map_from_robot_then = filter.MapFromRobot();
  frame.covariance = filter.RobotCovariance();
  frame.nis = observed.innovation.squared;
  frame.num_residuals = observed.innovation.degrees_of_freedom;
  frame.num_misfits = observed.num_misfits;
  frame.has_odometry = motion.unknown_time_s == 0;
  frame.has_slipped = observed.has_slipped;
  return frame;
}

void Count(const std::vector<CeilingFrame>& frames, CeilingEkfResult* result) {
  for (const CeilingFrame& frame : frames) {
    result->num_without_odometry += !frame.has_odometry;
    result->num_slipped += frame.has_slipped;
    result->num_blind += frame.num_residuals == 0;
  }
}

void CheckOdometry(const CeilingEkfOptions& options, const CeilingEkfResult& result) {
  const auto num_frames = static_cast<double>(result.map.frames.size());
  if (result.num_without_odometry > options.max_missing_ratio * num_frames) {
    throw InputError({{"odometry"}},
                     InputError::Remedy::kInText,
                     "sensor '{}' says nothing of {} of {} frames; correct time_offset_s of its "
                     "[[signal]] in the site config (`make inspect` shows the times), or raise "
                     "ceiling_ekf.max_odometry_gap_s or ceiling_ekf.max_missing_ratio",
                     result.odometry_sensor,
                     result.num_without_odometry,
                     result.map.frames.size());
  }
  if (result.num_without_odometry > 0) {
    spdlog::warn(
        "{} of {} frames have no odometry of '{}'; the robot was taken to go on at the "
        "speed that it had",
        result.num_without_odometry,
        result.map.frames.size(),
        result.odometry_sensor);
  }
  if (result.num_slipped > 0) {
    spdlog::warn(
        "the wheels of '{}' say otherwise than the pictures at {} frames; there the "
        "pictures are believed",
        result.odometry_sensor,
        result.num_slipped);
  }
}

}  // namespace

CeilingEkfResult RunCeilingEkf(const CeilingEkfOptions& options,
                               const CeilingEkfInput& input,
                               Progress& progress) {
  const Signal& wheels =
      ChooseOdometry(input.odometry, options.odometry.sensor, "ceiling_ekf.odometry_sensor");
  CeilingFilter filter(UpwardCamera(input.camera.color, input.camera.robot_from_camera),
                       options.noise);
  LandmarkKeeper keeper(options.keeper, &filter);
  Submaps submaps(options.loops, kMinLoopPath_m, input.tracks.descriptors);
  Motions motions(wheels, options.odometry.max_gap_s);
  std::vector<Step> steps;
  const std::vector<TrackedFrame>& frames = input.tracks.frames;
  progress.Start(frames.size());
  double path_m = 0, anchor_path_m = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ControlInput motion;
    if (i > 0) {
      motion = motions.Between(frames[i - 1].time_ns, frames[i].time_ns);
      filter.Predict(motion);
      path_m += motion.before_from_after.translation.norm();
    }
    const ObservedFrame observed = keeper.Observe(frames[i], motion);
    steps.push_back({Describe(frames[i], observed, motion, filter),
                     filter.NumAnchors() - 1,
                     filter.AnchorFromRobot()});
    const bool is_far = filter.AnchorFromRobot().translation.norm() > kAnchorDistance_m;
    if (is_far || path_m - anchor_path_m > kMaxWay * kAnchorDistance_m) {
      anchor_path_m = path_m;
      submaps.Leave(keeper.TakeStored(), keeper.Active(), path_m, &filter);
      filter.MoveAnchor();
    }
    progress.Advance();
  }
  keeper.Finish();
  submaps.Leave(keeper.TakeStored(), {}, path_m, &filter);
  progress.Finish();

  CeilingEkfResult result;
  result.odometry_sensor = wheels.sensor_id;
  for (const Step& step : steps) {
    CeilingFrame& frame = result.map.frames.emplace_back(step.frame);
    frame.map_from_robot = filter.MapFromAnchor(step.anchor) * step.anchor_from_robot;
  }
  submaps.Describe(&filter, &result.map);
  result.num_searches_without_loop = submaps.NumSearchesWithoutLoop();
  result.counts = keeper.Counts();
  result.heading_error_rad_per_m = filter.HeadingError_rad_per_m();
  result.mounting_tilt_rad = filter.MountingTilt_rad();
  result.map.mounting.head<2>() = result.mounting_tilt_rad;
  Count(result.map.frames, &result);
  CheckOdometry(options, result);
  return result;
}

}  // namespace nightmap
