// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_match/unclear_ways.h"

#include <cmath>

namespace nightmap {
namespace {

constexpr int kMinWindows = 5;
constexpr double kMinWay_m = 0.1;  // of a window that says something of the scale
constexpr double kMaxSigma = 0.01;
constexpr double kVariance_m2_per_m = 0.01;

// Least squares through the origin of the walls' metres over the wheels'.
class Slope {
 public:
  void Add(const Eigen::Vector2d& by_wheels_m, const Eigen::Vector2d& by_walls_m) {
    ++num_;
    xx_ += by_wheels_m.squaredNorm();
    xy_ += by_wheels_m.dot(by_walls_m);
    yy_ += by_walls_m.squaredNorm();
  }

  std::optional<double> Get() const {
    if (num_ < kMinWindows) return std::nullopt;
    const double slope = xy_ / xx_;
    const double variance = (yy_ - slope * xy_) / (2 * num_ - 1) / xx_;
    if (variance > kMaxSigma * kMaxSigma) return std::nullopt;
    return slope;
  }

 private:
  int num_ = 0;
  double xx_ = 0, xy_ = 0, yy_ = 0;
};

}  // namespace

std::optional<double> WheelScale(const std::vector<MatchedScan>& scans) {
  Slope slope;
  Rigid2 start_from_robot;  // by wheels, since the window's first scan
  std::size_t first = 0;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    const MatchedScan& scan = scans[i];
    if (!scan.is_matched || scan.unclear_in_robot || !scan.last_from_robot_by_wheels) {
      first = i;
      start_from_robot = {};
      continue;
    }
    start_from_robot = start_from_robot * *scan.last_from_robot_by_wheels;
    if (1e-9 * static_cast<double>(scan.time_ns - scans[first].time_ns) < kScaleWindow_s) continue;
    const Rigid2 by_walls = scans[first].start_from_robot.Inverse() * scan.start_from_robot;
    if (start_from_robot.translation.norm() > kMinWay_m) {
      slope.Add(start_from_robot.translation, by_walls.translation);
    }
    first = i;
    start_from_robot = {};
  }
  return slope.Get();
}

void ScaleUnclearWays(double scale, std::vector<MatchedScan>* scans) {
  Rigid2 last_before;  // as it was before its way was scaled
  for (std::size_t i = 0; i < scans->size(); ++i) {
    MatchedScan& scan = (*scans)[i];
    const Rigid2 before = scan.start_from_robot;
    if (i > 0) {
      Rigid2 last_from_robot = last_before.Inverse() * before;
      if (scan.unclear_in_robot && scan.last_from_robot_by_wheels) {
        const Eigen::Vector2d along =
            Eigen::Rotation2Dd(last_from_robot.heading_rad) * *scan.unclear_in_robot;
        last_from_robot.translation += (scale - 1) * last_from_robot.translation.dot(along) * along;
      }
      scan.start_from_robot = (*scans)[i - 1].start_from_robot * last_from_robot;
    }
    last_before = before;
  }
}

Eigen::Matrix3d UnclearCovariance(const MatchedScan& last, const MatchedScan& scan) {
  const double way_m =
      (scan.start_from_robot.translation - last.start_from_robot.translation).norm();
  const Eigen::Vector2d& along = *scan.unclear_in_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance.topLeftCorner<2, 2>() = kVariance_m2_per_m * way_m * along * along.transpose();
  return covariance;
}

}  // namespace nightmap
