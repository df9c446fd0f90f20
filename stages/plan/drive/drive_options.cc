// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/drive.h"

namespace nightmap {
namespace {

void RegisterLimits(MotionLimits& limits, OptionList& list) {
  list.Add("max_v_m_s", &limits.max_v_m_s, Range(0.01, 10.0), "largest speed, forwards");
  list.Add("max_omega_rad_s",
           &limits.max_omega_rad_s,
           Range(0.01, 20.0),
           "largest angular velocity, in either direction");
  list.Add("max_acceleration_m_s2",
           &limits.max_acceleration_m_s2,
           Range(0.01, 20.0),
           "largest acceleration and deceleration");
  list.Add("max_angular_acceleration_rad_s2",
           &limits.max_angular_acceleration_rad_s2,
           Range(0.01, 100.0),
           "largest angular acceleration and deceleration");
  list.Add(
      "period_s", &limits.period_s, Range(0.002, 0.5), "control period: a command holds this long");
}

void RegisterController(ControllerOptions& options, OptionList& list) {
  RegisterLimits(options.limits, list);
  list.Add("min_lookahead_m",
           &options.min_lookahead_m,
           Range(0.05, 10.0),
           "smallest distance along the path of the pursued point");
  list.Add("max_lookahead_m",
           &options.max_lookahead_m,
           Range(0.05, 10.0),
           "largest distance along the path of the pursued point");
  list.Add("lookahead_time_s",
           &options.lookahead_time_s,
           Range(0.1, 10.0),
           "time to the pursued point, in addition to the time to reach max_omega_rad_s");
  list.Add("max_bearing_deg",
           &options.max_bearing_deg,
           Range(5.0, 90.0),
           "the robot turns in place towards a point with a larger bearing");
  list.Add("slow_curve_radius_m",
           &options.slow_curve_radius_m,
           Range(0.0, 10.0),
           "tighter curves are driven more slowly, in proportion");
  list.Add("slow_clearance_m",
           &options.slow_clearance_m,
           Range(0.001, 10.0),
           "with less room between robot and obstacle the robot drives more slowly, in proportion");
  list.Add("min_v_m_s",
           &options.min_v_m_s,
           Range(0.005, 1.0),
           "neither rule slows down below this speed");
  list.Add("margin_m",
           &options.margin_m,
           Range(0.0, 1.0),
           "room to keep between robot and obstacle where the path allows it");
}

}  // namespace

void DriveOptions::Register(OptionList& list) {
  list.Add("robot_radius_m",
           &robot_radius_m,
           Range(0.0, 5.0),
           "radius of a round robot; 0: the radius for which the path was planned");
  list.Add("start_heading_deg",
           &start_heading_deg,
           "heading of the robot at the start, counter-clockwise from x; \"\": along the path");
  list.Add("goal_heading_deg",
           &goal_heading_deg,
           "heading on arrival; \"\": that of the path's last point");
  RegisterController(controller, list);
  list.Add("position_tolerance_m",
           &position_tolerance_m,
           Range(0.001, 10.0),
           "largest distance from the goal at which the robot may stop");
  list.Add("heading_tolerance_deg",
           &heading_tolerance_deg,
           Range(0.1, 180.0),
           "largest difference from the goal's heading at which the robot may stop");
  list.Add("max_duration_s", &max_duration_s, Range(0.1, 1e5), "longest simulated drive");
  noise.Register(list);
}

}  // namespace nightmap
