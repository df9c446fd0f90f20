// SPDX-License-Identifier: Apache-2.0
// Steers a differential-drive robot along a path by regulated pure pursuit (Macenski, Singh, Martin
// and Gines, Regulated pure pursuit for robot path tracking, 2023). A brake check rules out
// collisions.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "stages/plan/drive/clearance_map.h"
#include "stages/plan/drive/motion.h"
#include "stages/plan/drive/path_track.h"

namespace nightmap {

struct ControllerOptions {
  MotionLimits limits;
  double min_lookahead_m = 0.25;
  double max_lookahead_m = 0.6;
  // The lookahead distance is the speed times the sum of this and the time to start a turn.
  double lookahead_time_s = 0.7;
  double max_bearing_deg = 45;  // bearing of the pursued point; beyond it the robot stops and turns
  double slow_curve_radius_m = 0.5;  // tighter curves are driven more slowly
  double slow_clearance_m = 0.15;    // with less clearance than this the robot slows down
  double min_v_m_s = 0.05;           // neither rule slows down below this
  double margin_m = 0.02;            // room to obstacles that the robot keeps where the path has it
  // Standard deviations of the poses given to the controller. It does not try to be more exact.
  double position_sigma_m = 0;
  double heading_sigma_rad = 0;
};

// The robot pursues the farthest point within the lookahead distance that it reaches on an arc
// without a collision. Where no such point lies ahead, it stops and turns in place. A command is
// given only if the robot can still brake to rest after it without a collision (as in the dynamic
// window approach of Fox, Burgard and Thrun, 1997); otherwise the robot brakes. So a robot that
// starts without a collision never collides, as long as the poses it is told are true. At the goal
// it turns in place to the goal's heading. Deterministic.
class Controller {
 public:
  Controller(const ControllerOptions& options,
             const PathTrack& track,
             const ClearanceMap& map,
             std::optional<double> goal_heading_rad);  // none: any heading will do

  // Command for the period that begins at this pose; `twist` is the last command.
  Twist Command(const PlanarPose& pose, const Twist& twist);
  // The robot is at the goal, turned and at rest; the last command was zero.
  bool IsDone() const { return done_; }
  // Distance along the track that the robot has reached.
  double Progress_m() const { return progress_m_; }

 private:
  // A point of the track relative to the robot.
  struct Carrot {
    double lookahead_m = 0;
    Eigen::Vector2d point_in_robot = Eigen::Vector2d::Zero();
    bool is_goal = false;

    double Bearing_rad() const;
    double ArcCurvature() const;  // 1/m, of the arc to this point
  };

  double FindProgress_m(const Eigen::Vector2d& point) const;
  Carrot CarrotAt(const PlanarPose& pose, double lookahead_m) const;
  std::optional<Carrot> FindAhead(const PlanarPose& pose, double full_m, double room_m) const;
  std::optional<Carrot> FindInSight(const PlanarPose& pose, double full_m) const;
  bool IsWayClear(const PlanarPose& pose, double length_m, double turn_rad, double room_m) const;
  bool CanStop(PlanarPose pose, Twist twist) const;

  Twist Follow(const PlanarPose& pose, const Twist& twist);
  Twist Pursue(const PlanarPose& pose, const Carrot& carrot, double full_m) const;
  Twist Turn(double angle_rad) const;
  Twist MakeSafe(const PlanarPose& pose, const Twist& twist, const Twist& wish) const;

  const ControllerOptions& options_;
  const PathTrack& track_;
  const ClearanceMap& map_;
  std::optional<double> goal_heading_rad_;
  double time_s_;  // time to reach the pursued point
  double near_goal_m_;
  double reached_m_;
  double turned_rad_;
  double progress_m_ = 0;
  double pursued_m_ = 0;  // distance along the track
  bool turning_ = false;  // turning in place until the track is straight ahead
  bool at_goal_ = false;
  bool done_ = false;
};

}  // namespace nightmap
