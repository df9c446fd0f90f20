// SPDX-License-Identifier: Apache-2.0
#include "stages/drive/drive.h"

namespace nightmap {
namespace {

void RegisterLimits(MotionLimits& limits, OptionList& list) {
  list.Add("max_v_m_s", &limits.max_v_m_s, Range(0.01, 10.0), "largest speed, forwards");
  list.Add("max_omega_rad_s",
           &limits.max_omega_rad_s,
           Range(0.01, 20.0),
           "largest angular velocity, either way");
  list.Add("max_acceleration_m_s2",
           &limits.max_acceleration_m_s2,
           Range(0.01, 20.0),
           "largest acceleration and deceleration");
  list.Add("max_angular_acceleration_rad_s2",
           &limits.max_angular_acceleration_rad_s2,
           Range(0.01, 100.0),
           "the same of the angular velocity");
  list.Add("period_s", &limits.period_s, Range(0.002, 0.5), "of control: a command holds so long");
}

void RegisterController(ControllerOptions& options, OptionList& list) {
  RegisterLimits(options.limits, list);
  list.Add("min_lookahead_m",
           &options.min_lookahead_m,
           Range(0.05, 10.0),
           "distance along the path of the pursued point, at least");
  list.Add("max_lookahead_m", &options.max_lookahead_m, Range(0.05, 10.0), "the same, at most");
  list.Add("lookahead_time_s",
           &options.lookahead_time_s,
           Range(0.1, 10.0),
           "to that point, with the time it takes to reach max_omega_rad_s");
  list.Add("max_bearing_deg",
           &options.max_bearing_deg,
           Range(5.0, 90.0),
           "a point farther aside is turned to in place");
  list.Add("slow_curve_radius_m",
           &options.slow_curve_radius_m,
           Range(0.0, 10.0),
           "tighter curves are driven slower in proportion");
  list.Add("slow_clearance_m",
           &options.slow_clearance_m,
           Range(0.001, 10.0),
           "the same for less room between robot and obstacle than this");
  list.Add(
      "min_v_m_s", &options.min_v_m_s, Range(0.005, 1.0), "both slow down to no less than this");
  list.Add("margin_m",
           &options.margin_m,
           Range(0.0, 1.0),
           "room to keep between robot and obstacle where the path leaves it");
}

}  // namespace

void DriveOptions::Register(OptionList& list) {
  list.Add("robot_radius_m",
           &robot_radius_m,
           Range(0.0, 5.0),
           "radius of the round robot; 0: that for which the path was planned");
  list.Add("start_heading_deg",
           &start_heading_deg,
           "of the robot at rest, counter-clockwise from x; \"\": along the path");
  list.Add("goal_heading_deg", &goal_heading_deg, "to arrive with; \"\": the path's last");
  RegisterController(controller, list);
  list.Add("position_tolerance_m",
           &position_tolerance_m,
           Range(0.001, 10.0),
           "the robot must stop so near to the goal");
  list.Add("heading_tolerance_deg",
           &heading_tolerance_deg,
           Range(0.1, 180.0),
           "and turned so near to the goal's heading");
  list.Add("max_duration_s", &max_duration_s, Range(0.1, 1e5), "of the simulated drive");
  noise.Register(list);
}

}  // namespace nightmap
