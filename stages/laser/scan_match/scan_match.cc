// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_match/scan_match.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/base/input_error.h"
#include "pipeline/laser/match_scan.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/scan_points.h"
#include "stages/laser/scan_match/robot_motion.h"
#include "stages/laser/scan_match/scan_shape.h"
#include "stages/laser/scan_match/submaps.h"
#include "stages/laser/scan_match/unclear_ways.h"

namespace nightmap {
namespace {

constexpr int kSubmapKeyscans = 80;  // keyscans of a submap
// After a pause: sigmas of a robot that stood still, and the score that says so.
constexpr double kStill_m = 0.1;
constexpr double kStill_rad = 0.07;
constexpr double kSureScore = 0.6;

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

class Matcher {
 public:
  Matcher(const ScanMatchOptions& options, const Signal& scans, const Signal* wheels)
      : options_(options),
        signal_(scans),
        motion_(options, wheels),
        submaps_(options.field, kSubmapKeyscans) {}

  MatchedScan Next(const SignalSample& scan) {
    ScanShape shape = ShapeOf(options_, PointsOf(scan));
    const Prediction prediction = motion_.At(scan.time_ns);
    MatchedScan matched;
    matched.time_ns = scan.time_ns;
    matched.start_from_robot = prediction.start_from_robot.field_from_robot;
    matched.last_from_robot_by_wheels = prediction.last_from_robot;
    if (submaps_.IsEmpty()) {
      matched.is_matched = true;
    } else if (prediction.is_after_pause) {
      MatchAfterPause(shape, prediction, &matched);
    } else if (HasEnough(shape)) {
      Match(shape, prediction, &matched);
      if (matched.is_matched && IsMotionKnownBetterNow(scan)) {
        const Rigid2 motion =
            RobotMotion::MotionOver(*motion_.Last(), matched, signal_.scan_duration_s);
        shape = ShapeOf(options_, PointsInRobot(scan, signal_, motion.ToRigid3()));
        if (HasEnough(shape)) Match(shape, prediction, &matched);
      }
    }
    if (!matched.is_matched) lost_ += CovarianceOf(prediction.start_from_robot);
    if (matched.unclear_in_robot) lost_ += UnclearCovariance(*motion_.Last(), matched);
    const bool is_needed = NeedsKeyscan(matched.start_from_robot) || begins_part_;
    if (HasEnough(shape) && is_needed) AddKeyscan(shape, &matched);
    motion_.Add(matched);
    return matched;
  }

 private:
  bool HasEnough(const ScanShape& shape) const {
    return static_cast<int>(shape.points.size()) >= options_.min_points;
  }

  std::int64_t EndOf_ns(const SignalSample& scan) const {
    return scan.time_ns + std::llround(1e9 * signal_.scan_duration_s);
  }

  // Without wheels the motion to a scan that is matched tells more of the motion over it than the
  // one before.
  bool IsMotionKnownBetterNow(const SignalSample& scan) const {
    return signal_.scan_duration_s > 0 && motion_.Last() &&
           !motion_.ByWheels(scan.time_ns, EndOf_ns(scan));
  }

  // The points from where the robot is at the scan's time.
  ScanPoints PointsOf(const SignalSample& scan) const {
    if (signal_.scan_duration_s <= 0) return PointsInRobot(scan, signal_);
    const auto wheels = motion_.ByWheels(scan.time_ns, EndOf_ns(scan));
    return PointsInRobot(
        scan,
        signal_,
        wheels ? wheels->start_from_end : motion_.LastMotion(signal_.scan_duration_s).ToRigid3());
  }

  static Eigen::Matrix3d CovarianceOf(const PosePrior& prior) {
    return Eigen::Vector3d(prior.sigma_m, prior.sigma_m, prior.sigma_rad).cwiseAbs2().asDiagonal();
  }

  // Where the scan fits to nothing seen before, the robot is lost, and a new submap begins.
  void AddKeyscan(const ScanShape& shape, MatchedScan* matched) {
    matched->is_keyscan = true;
    if (!matched->is_matched) submaps_.Clear();
    submaps_.Add(matched->start_from_robot, shape.points);
    matched->covariance = lost_;
    if (matched->is_matched) matched->covariance += covariance_;
    lost_.setZero();
    begins_part_ = false;
    keyscan_ = *matched;
  }

  void Match(const ScanShape& shape, const Prediction& prediction, MatchedScan* matched) {
    const Submap& submap = submaps_.Older();
    PosePrior prior = prediction.start_from_robot;
    prior.field_from_robot = submap.start_from_submap.Inverse() * prior.field_from_robot;
    const FieldPyramid& pyramid = submaps_.PyramidOfOlder();
    ScanMatch match = MatchScan(pyramid, shape.points, prior);
    matched->score = match.score;
    if (match.score < options_.min_score) return;
    matched->is_matched = true;
    matched->unclear_in_robot.reset();
    const auto along =
        UnclearDirection(pyramid.Field(), shape.points, shape.normals, match.field_from_robot);
    if (along) {
      if (prediction.last_from_robot) {
        const Rigid2 held = MovedAlong(*along, match.field_from_robot, prior.field_from_robot);
        match = RefinePose(pyramid.Field(), shape.points, prior, held, {shape.normals, along});
      }
      matched->unclear_in_robot = Eigen::Rotation2Dd(-match.field_from_robot.heading_rad) * *along;
    }
    matched->start_from_robot = submap.start_from_submap * match.field_from_robot;
    covariance_ = CovarianceInRobot(match);
  }

  // A robot that paused stands where it stood, or a part of the way begins that loops join.
  void MatchAfterPause(const ScanShape& shape, Prediction prediction, MatchedScan* matched) {
    PosePrior& prior = prediction.start_from_robot;
    prior.sigma_m = kStill_m;
    prior.sigma_rad = kStill_rad;
    MatchedScan still = *matched;
    if (HasEnough(shape)) Match(shape, prediction, &still);
    begins_part_ = still.score < kSureScore;
    if (!begins_part_) *matched = still;
  }

  // The pose, moved along a direction to beside another one.
  static Rigid2 MovedAlong(const Eigen::Vector2d& along, Rigid2 pose, const Rigid2& other) {
    pose.translation += (other.translation - pose.translation).dot(along) * along;
    return pose;
  }

  bool NeedsKeyscan(const Rigid2& start_from_robot) const {
    if (!keyscan_) return true;
    const Rigid2 motion = keyscan_->start_from_robot.Inverse() * start_from_robot;
    return motion.translation.norm() > options_.keyscan_distance_m ||
           std::abs(motion.heading_rad) > options_.keyscan_angle_rad;
  }

  const ScanMatchOptions& options_;
  const Signal& signal_;
  RobotMotion motion_;
  Submaps submaps_;
  std::optional<MatchedScan> keyscan_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Identity();  // of the last match
  // The motion since the last keyscan has this covariance, as far as no walls tell it.
  Eigen::Matrix3d lost_ = Eigen::Matrix3d::Zero();
  bool begins_part_ = false;  // the next keyscan is seen by no submap before it
};

// An edge is the motion from one keyscan to the next. It has the covariance of the latter's pose.
std::vector<SensorEdge> EdgesOf(const std::vector<MatchedScan>& scans, const WheelNoise& noise) {
  std::vector<SensorEdge> edges;
  const MatchedScan* last = nullptr;
  for (const MatchedScan& scan : scans) {
    if (!scan.is_keyscan) continue;
    if (last) {
      const Rigid2 scan_from_last = scan.start_from_robot.Inverse() * last->start_from_robot;
      edges.push_back({EdgeKind::kOdometry,
                       last->time_ns,
                       scan.time_ns,
                       scan_from_last.ToRigid3(),
                       OnFloor(scan.covariance, noise.plane_sigma_m, noise.plane_sigma_rad)});
    }
    last = &scan;
  }
  return edges;
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
  progress.Start(scans.samples.size());
  for (const SignalSample& scan : scans.samples) {
    result.scans.push_back(matcher.Next(scan));
    progress.Advance();
  }
  result.wheel_scale = WheelScale(result.scans);
  ScaleUnclearWays(result.wheel_scale.value_or(1), &result.scans);
  result.edges.edges = EdgesOf(result.scans, options.wheels);
  return result;
}

}  // namespace nightmap
