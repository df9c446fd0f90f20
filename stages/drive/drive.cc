// SPDX-License-Identifier: Apache-2.0
#include "stages/drive/drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "stages/drive/keep_off.h"
#include "stages/drive/path_track.h"

namespace nightmap {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kStartDirection_m = 0.1;  // of the path, over which its direction is taken

double Heading_rad(const char* name, const std::string& text, double default_rad) {
  if (text.empty()) return default_rad;
  const auto value_deg = ParseReal(text);
  if (!value_deg) throw UsageError("option {} is '{}': give degrees or \"\"", name, text);
  return WrapAngle(*value_deg * kDegree);
}

Footprint FootprintOf(const DriveOptions& options, const PlannedPath& path) {
  if (options.robot_radius_m == 0 && !path.robot_radius_m) {
    throw UsageError("path.json does not say for which radius it was planned: set robot_radius_m");
  }
  return {options.robot_radius_m > 0 ? options.robot_radius_m : *path.robot_radius_m,
          !path.may_cross_unknown};
}

PlanarPose StartPose(const DriveOptions& options,
                     const DriveInputs& inputs,
                     const PathTrack& track) {
  const Eigen::Vector2d way = track.At(kStartDirection_m) - track.At(0);
  const double along_rad =
      way.norm() > 0 ? std::atan2(way.y(), way.x()) : inputs.path.goal_heading_rad;
  return {track.At(0), Heading_rad("start_heading_deg", options.start_heading_deg, along_rad)};
}

// From what of the path lies within some distance of where the robot is along it.
double Deviation_m(const PathTrack& track,
                   const Eigen::Vector2d& point,
                   double progress_m,
                   double reach_m) {
  const double nearest_m = track.Nearest_m(
      point, std::max(0.0, progress_m - reach_m), std::min(track.Length_m(), progress_m + reach_m));
  return (track.At(nearest_m) - point).norm();
}

void CheckStep(const DriveOptions& options, double min_clearance_m, const DriveResult& result) {
  const DriveStep& step = result.steps.back();
  const Eigen::Vector2d& point = step.pose.point_in_map;
  if (step.clearance_m < min_clearance_m) {
    throw ThresholdError(
        "the robot of radius {:.3f} m collides after {:.2f} s at {:.3f},{:.3f}: an obstacle is "
        "{:.3f} "
        "m away; if the grid is newer than the path run make plan, else plan with a larger "
        "robot_radius_m",
        result.footprint.radius_m,
        result.Duration_s(),
        point.x(),
        point.y(),
        step.clearance_m);
  }
  if (result.Duration_s() > options.max_duration_s) {
    throw ThresholdError(
        "the robot has not arrived after max_duration_s = {} s: it is at {:.3f},{:.3f}, {:.3f} m "
        "from "
        "the goal; allow more time or more speed",
        options.max_duration_s,
        point.x(),
        point.y(),
        (point - result.goal.point_in_map).norm());
  }
}

void CheckArrival(const DriveOptions& options, const DriveResult& result) {
  if (result.position_error_m <= options.position_tolerance_m &&
      result.heading_error_deg <= options.heading_tolerance_deg) {
    return;
  }
  throw ThresholdError(
      "the robot arrives {:.3f} m and {:.2f} deg off the goal, more than position_tolerance_m = {} "
      "or "
      "heading_tolerance_deg = {}",
      result.position_error_m,
      result.heading_error_deg,
      options.position_tolerance_m,
      options.heading_tolerance_deg);
}

void Summarize(DriveResult& result) {
  const PlanarPose& last = result.steps.back().pose;
  result.position_error_m = (last.point_in_map - result.goal.point_in_map).norm();
  result.heading_error_deg =
      std::abs(WrapAngle(last.heading_rad - result.goal.heading_rad)) / kDegree;
  result.min_clearance_m = result.steps[0].clearance_m;
  for (const DriveStep& step : result.steps) {
    result.length_m += step.command.v_m_s * result.period_s;
    result.min_clearance_m = std::min(result.min_clearance_m, step.clearance_m);
    result.max_deviation_m = std::max(result.max_deviation_m, step.deviation_m);
  }
}

}  // namespace

DriveResult RunDrive(const DriveOptions& options, const DriveInputs& inputs, Progress& progress) {
  const ControllerOptions& steering = options.controller;
  if (steering.min_lookahead_m > steering.max_lookahead_m) {
    throw UsageError("min_lookahead_m {} is above max_lookahead_m {}",
                     steering.min_lookahead_m,
                     steering.max_lookahead_m);
  }
  const PathTrack track(inputs.path.points_in_map);
  DriveResult result;
  result.footprint = FootprintOf(options, inputs.path);
  const ClearanceMap map(inputs.grid, result.footprint);
  result.period_s = steering.limits.period_s;
  result.path_length_m = track.Length_m();
  result.goal = {
      track.At(track.Length_m()),
      Heading_rad("goal_heading_deg", options.goal_heading_deg, inputs.path.goal_heading_rad)};

  progress.Start(1);
  const PathTrack pursued(KeepOff(map, inputs.path.points_in_map, steering.margin_m));
  Controller controller(steering, pursued, map, result.goal.heading_rad);
  DriveStep step{StartPose(options, inputs, track), {}, 0, 0};
  while (true) {
    const Eigen::Vector2d& point = step.pose.point_in_map;
    const Twist last = step.command;
    step.command = {};
    step.clearance_m = map.Clearance_m(point);
    step.deviation_m = Deviation_m(track, point, controller.Progress_m(), steering.max_lookahead_m);
    result.steps.push_back(step);
    CheckStep(options, map.MinClearance_m(), result);
    step.command = controller.Command(step.pose, last);
    if (controller.IsDone()) break;
    result.steps.back().command = step.command;
    step.pose = Advance(step.pose, step.command, result.period_s);
  }
  Summarize(result);
  CheckArrival(options, result);
  progress.Finish();
  return result;
}

}  // namespace nightmap
