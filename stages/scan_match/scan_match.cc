// SPDX-License-Identifier: Apache-2.0
#include "stages/scan_match/scan_match.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/planar/match_scan.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/scan_points.h"
#include "pipeline/recording/wheel_motion.h"
#include "stages/scan_match/submaps.h"

namespace nightmap {
namespace {

// Null: without.
const Signal* ChooseOdometry(const std::string& sensor, const std::vector<Signal>& odometry) {
  if (sensor == "none" || (sensor.empty() && odometry.empty())) return nullptr;
  if (sensor.empty() && odometry.size() == 1) return &odometry.front();
  const auto found = std::ranges::find(odometry, sensor, &Signal::sensor_id);
  if (found != odometry.end()) return &*found;
  std::vector<std::string> ids;
  for (const Signal& signal : odometry) ids.push_back(signal.sensor_id);
  throw UsageError(
      "scan_match.odometry_sensor is '{}': choose \"none\" or one of the sensors of odometry: {}",
      sensor,
      fmt::join(ids, ", "));
}

// Points near enough to be sure of, one per cell: many beams on a wall nearby say no more.
std::vector<Eigen::Vector2d> Thinned(const ScanMatchOptions& options, const ScanPoints& scan) {
  std::vector<Eigen::Vector2d> points;
  Eigen::Vector2d last = Eigen::Vector2d::Constant(1e9);
  for (const Eigen::Vector3d& point : scan.points_in_robot) {
    if (point.head<2>().norm() > options.max_range_m) continue;
    if ((point.head<2>() - last).norm() < options.field.resolution_m) continue;
    last = point.head<2>();
    points.push_back(last);
  }
  return points;
}

class Matcher {
 public:
  Matcher(const ScanMatchOptions& options, const Signal& scans, const Signal* wheels)
      : options_(options),
        signal_(scans),
        wheels_(wheels),
        submaps_(options.field, options.submap_keyscans) {}

  MatchedScan Next(const SignalSample& scan) {
    std::vector<Eigen::Vector2d> points = Thinned(options_, PointsOf(scan));
    const PosePrior prior = Predict(scan.time_ns);
    MatchedScan matched{scan.time_ns, prior.field_from_robot, 0, false, false};
    if (submaps_.IsEmpty()) {
      matched.is_matched = true;
    } else if (HasEnough(points)) {
      Match(points, prior, &matched);
      if (matched.is_matched && IsMotionKnownBetterNow(scan)) {
        const Rigid2 motion = MotionOver(*last_, matched, signal_.scan_duration_s);
        points = Thinned(options_, PointsInRobot(scan, signal_, motion.ToRigid3()));
        if (HasEnough(points)) Match(points, prior, &matched);
      }
    }
    if (!matched.is_matched) lost_ += CovarianceOf(prior);
    if (HasEnough(points) && NeedsKeyscan(matched.start_from_robot)) AddKeyscan(points, &matched);
    before_last_ = std::exchange(last_, matched);
    return matched;
  }

  // The covariance of the motion to the last keyscan: of its match, and of predictions before it.
  const Eigen::Matrix3d& Covariance() const { return covariance_of_keyscan_; }

 private:
  bool HasEnough(const std::vector<Eigen::Vector2d>& points) const {
    return static_cast<int>(points.size()) >= options_.min_points;
  }

  std::int64_t EndOf_ns(const SignalSample& scan) const {
    return scan.time_ns + std::llround(1e9 * signal_.scan_duration_s);
  }

  // Without wheels the motion to a scan that is matched tells more of the motion over it than the
  // one before.
  bool IsMotionKnownBetterNow(const SignalSample& scan) const {
    return signal_.scan_duration_s > 0 && last_ && !WheelsSince(scan.time_ns, EndOf_ns(scan));
  }

  // The points from where the robot is at the scan's time.
  ScanPoints PointsOf(const SignalSample& scan) const {
    if (signal_.scan_duration_s <= 0) return PointsInRobot(scan, signal_);
    const auto wheels = WheelsSince(scan.time_ns, EndOf_ns(scan));
    return PointsInRobot(
        scan,
        signal_,
        wheels ? wheels->start_from_end : LastMotion(signal_.scan_duration_s).ToRigid3());
  }

  static Eigen::Matrix3d CovarianceOf(const PosePrior& prior) {
    return Eigen::Vector3d(prior.sigma_m, prior.sigma_m, prior.sigma_rad).cwiseAbs2().asDiagonal();
  }

  // Where the scan fits to nothing seen before, the robot is lost, and a new submap begins.
  void AddKeyscan(const std::vector<Eigen::Vector2d>& points, MatchedScan* matched) {
    matched->is_keyscan = true;
    if (!matched->is_matched) submaps_.Clear();
    submaps_.Add(matched->start_from_robot, points);
    covariance_of_keyscan_ = lost_;
    if (matched->is_matched) covariance_of_keyscan_ += covariance_;
    lost_.setZero();
    keyscan_ = *matched;
  }

  // start_from_robot at a time, by the wheels or by the last motion.
  PosePrior Predict(std::int64_t time_ns) const {
    if (!last_) return {};
    const double passed_s = 1e-9 * static_cast<double>(time_ns - last_->time_ns);
    if (const auto motion = WheelsSince(last_->time_ns, time_ns)) {
      const WheelNoise& noise = options_.wheels;
      const Eigen::Quaterniond& turn = motion->start_from_end.rotation;
      const Rigid2 last_from_robot{2 * std::atan2(turn.z(), turn.w()),
                                   motion->start_from_end.translation.head<2>()};
      return {last_->start_from_robot * last_from_robot,
              noise.PositionSigma_m(*motion),
              noise.HeadingSigma_rad(*motion)};
    }
    return {last_->start_from_robot * LastMotion(passed_s),
            options_.wheels.position_sigma_floor_m + options_.walking_sigma_m_per_s * passed_s,
            options_.wheels.heading_sigma_floor_rad + options_.walking_sigma_rad_per_s * passed_s};
  }

  std::optional<WheelMotion> WheelsSince(std::int64_t start_ns, std::int64_t end_ns) const {
    if (!wheels_) return std::nullopt;
    return MotionBetween(wheels_->samples, options_.wheels.max_gap_s, start_ns, end_ns);
  }

  // The motion between the last two scans, over the time that has passed since.
  Rigid2 LastMotion(double passed_s) const {
    return before_last_ ? MotionOver(*before_last_, *last_, passed_s) : Rigid2{};
  }

  // The part of the motion from a to b that goes into a time.
  static Rigid2 MotionOver(const MatchedScan& a, const MatchedScan& b, double passed_s) {
    const double between_s = 1e-9 * static_cast<double>(b.time_ns - a.time_ns);
    const Rigid2 motion = a.start_from_robot.Inverse() * b.start_from_robot;
    const double ratio = std::min(passed_s / between_s, 1.0);
    return {ratio * motion.heading_rad, ratio * motion.translation};
  }

  void Match(const std::vector<Eigen::Vector2d>& points, PosePrior prior, MatchedScan* matched) {
    const Submap& submap = submaps_.Older();
    prior.field_from_robot = submap.start_from_submap.Inverse() * prior.field_from_robot;
    const ScanMatch match = MatchScan(submaps_.PyramidOfOlder(), points, prior);
    matched->score = match.score;
    if (match.score < options_.min_score) return;
    matched->is_matched = true;
    matched->start_from_robot = submap.start_from_submap * match.field_from_robot;
    covariance_ = CovarianceInRobot(match);
  }

  bool NeedsKeyscan(const Rigid2& start_from_robot) const {
    if (!keyscan_) return true;
    const Rigid2 motion = keyscan_->start_from_robot.Inverse() * start_from_robot;
    return motion.translation.norm() > options_.keyscan_distance_m ||
           std::abs(motion.heading_rad) > options_.keyscan_angle_rad;
  }

  const ScanMatchOptions& options_;
  const Signal& signal_;
  const Signal* wheels_;
  Submaps submaps_;
  std::optional<MatchedScan> last_, before_last_, keyscan_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Identity();  // of the last match
  Eigen::Matrix3d lost_ = Eigen::Matrix3d::Zero();  // of the motion of scans that fit nowhere
  Eigen::Matrix3d covariance_of_keyscan_ = Eigen::Matrix3d::Identity();
};

// An edge is the motion from one keyscan to the next. It has the covariance of the latter's pose.
SensorEdge EdgeBetween(const MatchedScan& a, const MatchedScan& b, const Matrix6d& covariance) {
  const Rigid2 b_from_a = b.start_from_robot.Inverse() * a.start_from_robot;
  return {EdgeKind::kOdometry, a.time_ns, b.time_ns, b_from_a.ToRigid3(), covariance};
}

}  // namespace

ScanMatchOptions::ScanMatchOptions() {
  wheels.position_sigma_floor_m = 0.1;
  wheels.position_sigma_per_distance = 0.1;
  wheels.position_sigma_m_per_rad = 0.03;
  wheels.heading_sigma_floor_rad = 0.03;
  wheels.heading_sigma_rad_per_m = 0.03;
  wheels.heading_sigma_per_turn = 0.1;
  wheels.max_gap_s = 10;
}

ScanMatchResult RunScanMatch(const ScanMatchOptions& options,
                             const ScanMatchInput& input,
                             Progress& progress) {
  const Signal& scans = ChooseScanner(input.scans, options.scan_sensor, "scan_match.scan_sensor");
  const Signal* wheels = ChooseOdometry(options.odometry_sensor, input.odometry);
  ScanMatchResult result;
  result.scan_sensor = scans.sensor_id;
  if (wheels) result.odometry_sensor = wheels->sensor_id;
  result.edges.sensor = scans.sensor_id;
  Matcher matcher(options, scans, wheels);
  std::optional<MatchedScan> keyscan;
  progress.Start(scans.samples.size());
  for (const SignalSample& scan : scans.samples) {
    const MatchedScan matched = matcher.Next(scan);
    result.scans.push_back(matched);
    if (matched.is_keyscan) {
      if (keyscan) {
        result.edges.edges.push_back(EdgeBetween(*keyscan,
                                                 matched,
                                                 OnFloor(matcher.Covariance(),
                                                         options.wheels.plane_sigma_m,
                                                         options.wheels.plane_sigma_rad)));
      }
      keyscan = matched;
    }
    progress.Advance();
  }
  return result;
}

}  // namespace nightmap
