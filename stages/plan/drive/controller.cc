// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/controller.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace nightmap {
namespace {

constexpr double kDeg = std::numbers::pi / 180;
constexpr double kShorter = 0.8;      // ratio of a tried lookahead to the previous one
constexpr double kShortest_m = 0.03;  // shortest lookahead
constexpr double kTight_m = 0.1;  // likewise without a margin, so that the robot stays on the track
constexpr double kAligned_rad = 1 * kDeg;  // a turn in place ends within this angle
constexpr double kTurned_rad = 1e-4;
// No more steering: the bearing of a point so near means nothing.
constexpr double kNearGoal_m = 0.02;
constexpr double kReached_m = 1e-4;
constexpr double kSpacing_m = 0.01;  // between checked poses on an arc
constexpr int kNumSpeeds = 4;        // speeds tried between the wish and the slowest possible

}  // namespace

double Controller::Carrot::Bearing_rad() const {
  return std::atan2(point_in_robot.y(), point_in_robot.x());
}

double Controller::Carrot::ArcCurvature() const {
  return 2 * point_in_robot.y() / point_in_robot.squaredNorm();
}

Controller::Controller(const ControllerOptions& options,
                       const PathTrack& track,
                       const ClearanceMap& map,
                       std::optional<double> goal_heading_rad)
    : options_(options),
      track_(track),
      map_(map),
      goal_heading_rad_(goal_heading_rad),
      time_s_(options.lookahead_time_s +
              options.limits.max_omega_rad_s / options.limits.max_angular_acceleration_rad_s2),
      near_goal_m_(std::max(kNearGoal_m, 3 * options.position_sigma_m)),
      reached_m_(std::max(kReached_m, options.position_sigma_m)),
      turned_rad_(std::max(kTurned_rad, options.heading_sigma_rad)) {}

Controller::Carrot Controller::CarrotAt(const PlanarPose& pose, double lookahead_m) const {
  const double at_m = progress_m_ + lookahead_m;
  const Eigen::Vector2d offset = track_.At(at_m) - pose.point_in_map;
  return {lookahead_m, Eigen::Rotation2Dd(-pose.heading_rad) * offset, at_m >= track_.Length_m()};
}

bool Controller::IsWayClear(const PlanarPose& pose,
                            double length_m,
                            double turn_rad,
                            double room_m) const {
  const int num_steps = 1 + static_cast<int>(length_m / kSpacing_m);
  for (int i = 1; i <= num_steps; ++i) {
    const PlanarPose on_way =
        Advance(pose, {length_m, turn_rad}, static_cast<double>(i) / num_steps);
    if (!map_.IsClear(on_way.point_in_map, room_m)) return false;
  }
  return true;
}

// The nearest point not beyond the pursued one. Around a corner that point may lie behind an
// obstacle; then takes one that is less far along.
double Controller::FindProgress_m(const Eigen::Vector2d& point) const {
  for (double ahead_m = pursued_m_ - progress_m_; ahead_m > kReached_m; ahead_m *= 0.5) {
    const double nearest_m = track_.Nearest_m(point, progress_m_, progress_m_ + ahead_m);
    const Eigen::Vector2d way = track_.At(nearest_m) - point;
    const PlanarPose towards{point, std::atan2(way.y(), way.x())};
    if (IsWayClear(towards, way.norm(), 0, 0)) return nearest_m;
  }
  return progress_m_;
}

// The farthest point that an arc leads to.
std::optional<Controller::Carrot> Controller::FindAhead(const PlanarPose& pose,
                                                        double full_m,
                                                        double room_m) const {
  for (double lookahead_m = full_m; lookahead_m > kShortest_m; lookahead_m *= kShorter) {
    const Carrot carrot = CarrotAt(pose, lookahead_m);
    const double bearing_rad = carrot.Bearing_rad();
    const double chord_m = carrot.point_in_robot.norm();
    if (std::abs(bearing_rad) > options_.max_bearing_deg * kDeg || chord_m < kReached_m) continue;
    const double arc_m = bearing_rad == 0 ? chord_m : chord_m * bearing_rad / std::sin(bearing_rad);
    if (IsWayClear(pose, arc_m, 2 * bearing_rad, room_m)) return carrot;
  }
  return std::nullopt;
}

// The farthest point that a straight line reaches in any direction. Asks for more room than an arc
// needs, because a turn in place is less exact.
std::optional<Controller::Carrot> Controller::FindInSight(const PlanarPose& pose,
                                                          double full_m) const {
  for (const double room_m : {options_.margin_m, 0.1 * options_.margin_m, 0.0}) {
    const double first_m = room_m == options_.margin_m ? full_m : kTight_m;
    for (double lookahead_m = first_m; lookahead_m > kShortest_m; lookahead_m *= kShorter) {
      const Carrot carrot = CarrotAt(pose, lookahead_m);
      const PlanarPose turned{pose.point_in_map, pose.heading_rad + carrot.Bearing_rad()};
      if (IsWayClear(turned, carrot.point_in_robot.norm(), 0, room_m)) return carrot;
    }
  }
  return std::nullopt;
}

Twist Controller::Turn(double angle_rad) const {
  if (std::abs(angle_rad) < turned_rad_) return {};
  const MotionLimits& limits = options_.limits;
  const double omega_rad_s = SpeedToStopWithin(
      std::abs(angle_rad), limits.max_angular_acceleration_rad_s2, limits.period_s);
  return {0, std::copysign(std::min(omega_rad_s, limits.max_omega_rad_s), angle_rad)};
}

Twist Controller::Pursue(const PlanarPose& pose, const Carrot& carrot, double full_m) const {
  const MotionLimits& limits = options_.limits;
  const bool near_goal = carrot.is_goal && carrot.point_in_robot.norm() < near_goal_m_;
  const double curvature_per_m = near_goal ? 0 : carrot.ArcCurvature();
  const double room_m = map_.Room_m(pose.point_in_map);
  double v_m_s = limits.max_v_m_s;
  v_m_s *= std::clamp(room_m / options_.slow_clearance_m, 0.0, 1.0);
  v_m_s *= std::min(1.0, 1 / (options_.slow_curve_radius_m * std::abs(curvature_per_m) + 1e-9));
  const bool sees_all = carrot.lookahead_m >= full_m;
  v_m_s = std::min(v_m_s, (sees_all ? options_.max_lookahead_m : carrot.lookahead_m) / time_s_);
  v_m_s = std::max(v_m_s, options_.min_v_m_s);
  v_m_s = std::min(v_m_s, limits.max_omega_rad_s / (std::abs(curvature_per_m) + 1e-9));
  const double left_m =
      carrot.is_goal ? carrot.point_in_robot.x() : track_.Length_m() - progress_m_;
  const double stop_m_s = SpeedToStopWithin(left_m, limits.max_acceleration_m_s2, limits.period_s);
  v_m_s = std::min(v_m_s, left_m < reached_m_ ? 0 : stop_m_s);
  return {v_m_s, curvature_per_m * v_m_s};
}

Twist Controller::Follow(const PlanarPose& pose, const Twist& twist) {
  const double full_m =
      std::clamp(twist.v_m_s * time_s_, options_.min_lookahead_m, options_.max_lookahead_m);
  progress_m_ = FindProgress_m(pose.point_in_map);
  const Carrot goal = CarrotAt(pose, track_.Length_m());
  if (goal.point_in_robot.norm() < near_goal_m_ && progress_m_ + full_m > track_.Length_m()) {
    const Twist wish = Pursue(pose, goal, full_m);
    at_goal_ = twist.IsRest() && wish.IsRest();
    return wish;
  }
  if (!turning_) {
    auto carrot = FindAhead(pose, full_m, 0.5 * options_.margin_m);
    if (!carrot) carrot = FindAhead(pose, kTight_m, 0);
    if (carrot) {
      pursued_m_ = progress_m_ + carrot->lookahead_m;
      return Pursue(pose, *carrot, full_m);
    }
  }
  turning_ = true;
  if (twist.v_m_s > 0) return Brake(twist, options_.limits);
  const auto carrot = FindInSight(pose, full_m);
  if (!carrot) {  // back to where the track was in sight
    pursued_m_ = progress_m_ = std::max(0.0, progress_m_ - kShortest_m);
    return {};
  }
  const double bearing_rad = carrot->Bearing_rad();
  turning_ = std::abs(bearing_rad) > kAligned_rad || twist.omega_rad_s != 0;
  return Turn(bearing_rad);
}

bool Controller::CanStop(PlanarPose pose, Twist twist) const {
  while (map_.IsClear(pose.point_in_map)) {
    if (twist.v_m_s == 0) return true;
    twist = Brake(twist, options_.limits);
    pose = Advance(pose, twist, options_.limits.period_s);
  }
  return false;
}

Twist Controller::MakeSafe(const PlanarPose& pose, const Twist& twist, const Twist& wish) const {
  const MotionLimits& limits = options_.limits;
  const double curvature_per_m = wish.v_m_s > 0 ? wish.omega_rad_s / wish.v_m_s : 0;
  const double fastest_m_s = Reach(twist, wish, limits).v_m_s;
  const double slowest_m_s = std::min(fastest_m_s, Reach(twist, {}, limits).v_m_s);
  for (int i = 0; i <= kNumSpeeds; ++i) {
    const double v_m_s = fastest_m_s + (slowest_m_s - fastest_m_s) * i / kNumSpeeds;
    const double omega_rad_s = wish.v_m_s > 0 ? curvature_per_m * v_m_s : wish.omega_rad_s;
    const Twist command = Reach(twist, {v_m_s, omega_rad_s}, limits);
    if (CanStop(Advance(pose, command, limits.period_s), command)) return command;
  }
  return Brake(twist, limits);
}

Twist Controller::Command(const PlanarPose& pose, const Twist& twist) {
  Twist wish;
  if (at_goal_) {
    if (goal_heading_rad_) wish = Turn(WrapAngle(*goal_heading_rad_ - pose.heading_rad));
    done_ = wish.IsRest() && twist.IsRest();
  } else {
    wish = Follow(pose, twist);
  }
  return MakeSafe(pose, twist, wish);
}

}  // namespace nightmap
