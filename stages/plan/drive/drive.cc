// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "stages/plan/drive/check_path.h"
#include "stages/plan/drive/move_off_obstacles.h"
#include "stages/plan/drive/path_track.h"

namespace nightmap {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kNumSigmas = 3;           // sigmas of a told position, added to the margin
constexpr double kMaxCut = 2;              // longest path over the robot's way, which cuts corners
constexpr double kStartDirection_m = 0.1;  // of the path, over which its direction is measured

double Heading_rad(const char* name, const std::string& text, double default_rad) {
  if (text.empty()) return default_rad;
  const auto value_deg = ParseReal(text);
  if (!value_deg || std::abs(*value_deg) > 360) {
    throw UsageError("option {} is '{}': give degrees between -360 and 360, or \"\"", name, text);
  }
  return WrapAngle(*value_deg * kDegree);
}

PlanarPose StartPose(const DriveOptions& options, const PlannedPath& path) {
  const PathTrack track(path.legs_in_map.front());
  const Eigen::Vector2d way = track.At(kStartDirection_m) - track.At(0);
  const double along_rad = way.norm() > 0 ? std::atan2(way.y(), way.x()) : path.goal_heading_rad;
  return {track.At(0), Heading_rad("start_heading_deg", options.start_heading_deg, along_rad)};
}

// Distance to the part of the path near the robot's position along it.
double Deviation_m(const PathTrack& track,
                   const Eigen::Vector2d& point,
                   double progress_m,
                   double reach_m) {
  const double nearest_m = track.Nearest_m(
      point, std::max(0.0, progress_m - reach_m), std::min(track.Length_m(), progress_m + reach_m));
  return (track.At(nearest_m) - point).norm();
}

// The drive so far, extended leg by leg.
class Simulation {
 public:
  Simulation(const DriveOptions& options, const DriveInputs& inputs)
      : options_(options),
        steering_(Steering(options)),
        map_(inputs.grid, FootprintOf(options, inputs.path)),
        noise_(options.noise,
               2 * FootprintOf(options, inputs.path).radius_m,
               options.controller.limits.period_s) {
    result_.floor = inputs.path.floor;
    result_.footprint = FootprintOf(options, inputs.path);
    result_.period_s = options.controller.limits.period_s;
    result_.steps.push_back({StartPose(options, inputs.path), {}, 0, 0});
  }

  // Drives until the robot rests at the leg's end, turned to the goal heading if there is one.
  void DriveLeg(const std::vector<Eigen::Vector2d>& leg, std::optional<double> goal_heading_rad) {
    const PathTrack track(leg);
    const PathTrack pursued(MoveOffObstacles(map_, leg, steering_.margin_m));
    Controller controller(steering_, pursued, map_, goal_heading_rad);
    Twist last;
    while (true) {
      DriveStep& step = result_.steps.back();
      const Eigen::Vector2d& point = step.pose.point_in_map;
      step.clearance_m = map_.Clearance_m(point);
      step.deviation_m =
          Deviation_m(track, point, controller.Progress_m(), options_.controller.max_lookahead_m);
      CheckCollision(step);
      CheckTime(point, leg.back());
      const Twist command = controller.Command(noise_.Told(step.pose), last);
      if (controller.IsDone()) break;
      step.command = last = command;
      const Twist moved = noise_.Moved(command);
      result_.length_m += moved.v_m_s * result_.period_s;
      const PlanarPose next = Advance(step.pose, moved, result_.period_s);
      result_.steps.push_back({next, {}, 0, 0});
    }
    CheckArrival(leg.back(), goal_heading_rad);
    result_.path_length_m += track.Length_m();
  }

  DriveResult Take() {
    result_.min_clearance_m = result_.steps[0].clearance_m;
    for (const DriveStep& step : result_.steps) {
      result_.min_clearance_m = std::min(result_.min_clearance_m, step.clearance_m);
      result_.max_deviation_m = std::max(result_.max_deviation_m, step.deviation_m);
    }
    return std::move(result_);
  }

 private:
  // The controller knows how well it is localized.
  static ControllerOptions Steering(const DriveOptions& options) {
    ControllerOptions steering = options.controller;
    steering.position_sigma_m = options.noise.position_noise_m;
    steering.heading_sigma_rad = options.noise.heading_noise_rad;
    steering.margin_m += kNumSigmas * steering.position_sigma_m;
    return steering;
  }

  static Footprint FootprintOf(const DriveOptions& options, const PlannedPath& path) {
    const double radius_m =
        options.robot_radius_m > 0 ? options.robot_radius_m : path.robot_radius_m;
    return {radius_m, !path.may_cross_unknown, path.max_hole_m};
  }

  void CheckCollision(const DriveStep& step) const {
    if (map_.IsClear(step.pose.point_in_map)) return;
    throw ThresholdError(
        "the robot of radius {:.3f} m collides after {:.2f} s at {:.3f},{:.3f}, {:.3f} m from an "
        "obstacle: {}",
        result_.footprint.radius_m,
        result_.Duration_s(),
        step.pose.point_in_map.x(),
        step.pose.point_in_map.y(),
        step.clearance_m,
        options_.noise.IsNone()
            ? "run make plan again, the path is for another grid or a smaller robot"
            : "plan for a larger robot_radius_m than that of drive, or allow less noise");
  }

  void CheckTime(const Eigen::Vector2d& point, const Eigen::Vector2d& goal) const {
    if (result_.Duration_s() <= options_.max_duration_s) return;
    throw ThresholdError(
        "the robot has not arrived after max_duration_s = {} s: it is at {:.3f},{:.3f}, {:.3f} m "
        "from the goal; allow more time or speed, or run make plan again if the grid is newer",
        options_.max_duration_s,
        point.x(),
        point.y(),
        (point - goal).norm());
  }

  void CheckArrival(const Eigen::Vector2d& goal, std::optional<double> goal_heading_rad) {
    const PlanarPose& pose = result_.steps.back().pose;
    const double turn_rad =
        WrapAngle(pose.heading_rad - goal_heading_rad.value_or(pose.heading_rad));
    const double off_m = (pose.point_in_map - goal).norm();
    const double off_deg = std::abs(turn_rad) / kDegree;
    if (off_m > options_.position_tolerance_m || off_deg > options_.heading_tolerance_deg) {
      throw ThresholdError(
          "the robot stops {:.3f} m and {:.2f} deg off the goal at {:.3f},{:.3f}: more than "
          "position_tolerance_m = {} or heading_tolerance_deg = {}",
          off_m,
          off_deg,
          goal.x(),
          goal.y(),
          options_.position_tolerance_m,
          options_.heading_tolerance_deg);
    }
    result_.position_error_m = std::max(result_.position_error_m, off_m);
    result_.heading_error_deg = std::max(result_.heading_error_deg, off_deg);
    ++result_.num_goals;
  }

  const DriveOptions& options_;
  ControllerOptions steering_;
  ClearanceMap map_;
  Noise noise_;
  DriveResult result_;
};

// Refuses a drive that cannot end in time before doing its work.
void CheckLength(const DriveOptions& options, const PlannedPath& path) {
  double length_m = 0;
  for (const auto& leg : path.legs_in_map) length_m += PathTrack(leg).Length_m();
  const double max_m = kMaxCut * options.controller.limits.max_v_m_s * options.max_duration_s;
  if (length_m <= max_m) return;
  throw ThresholdError(
      "the path is {:.1f} m long: at max_v_m_s = {} no robot arrives within max_duration_s = "
      "{} s; allow more time or speed",
      length_m,
      options.controller.limits.max_v_m_s,
      options.max_duration_s);
}

}  // namespace

DriveResult RunDrive(const DriveOptions& options, const DriveInputs& inputs, Progress& progress) {
  const ControllerOptions& steering = options.controller;
  if (steering.min_lookahead_m > steering.max_lookahead_m) {
    throw UsageError("min_lookahead_m {} is above max_lookahead_m {}",
                     steering.min_lookahead_m,
                     steering.max_lookahead_m);
  }
  const double goal_heading_rad =
      Heading_rad("goal_heading_deg", options.goal_heading_deg, inputs.path.goal_heading_rad);
  CheckOnGrid(inputs.path, inputs.grid);
  CheckLength(options, inputs.path);
  const auto& legs = inputs.path.legs_in_map;
  progress.Start(legs.size());
  Simulation simulation(options, inputs);
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const bool is_last = i + 1 == legs.size();
    simulation.DriveLeg(legs[i], is_last ? std::optional(goal_heading_rad) : std::nullopt);
    progress.Advance();
  }
  progress.Finish();
  return simulation.Take();
}

}  // namespace nightmap
