// SPDX-License-Identifier: Apache-2.0
// Shared by tests: a laser scanner in a building of boxes, and the keyscans of a drive in it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

// The first box of a building is seen from inside, the others from outside. Metres.
struct Box2 {
  Eigen::Vector2d low, high;
};
using Building = std::vector<Box2>;

inline double RangeToWall_m(const Building& building,
                            const Eigen::Vector2d& from,
                            double heading_rad) {
  const Eigen::Vector2d direction(std::cos(heading_rad), std::sin(heading_rad));
  double range_m = 1e9;
  for (const Box2& box : building) {
    double enter = -1e9, leave = 1e9;
    for (int i = 0; i < 2; ++i) {
      const double a = (box.low[i] - from[i]) / direction[i];
      const double b = (box.high[i] - from[i]) / direction[i];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    const bool is_inside = &box == &building.front();
    if (is_inside) range_m = std::min(range_m, leave);
    if (!is_inside && enter < leave && enter > 0) range_m = std::min(range_m, enter);
  }
  return range_m;
}

// All around, a beam each degree.
inline SignalSample ScanAllAround(std::int64_t time_ns,
                                  const Building& building,
                                  const Rigid2& pose,
                                  double noise_m,
                                  Random& random) {
  constexpr double kDegree_rad = std::numbers::pi / 180;
  SignalSample sample{time_ns, {-std::numbers::pi, kDegree_rad, 80}, {}};
  for (int beam = -180; beam < 180; ++beam) {
    const double range_m =
        RangeToWall_m(building, pose.translation, pose.heading_rad + beam * kDegree_rad);
    sample.ranges_m.push_back(static_cast<float>(range_m + random.Uniform(-noise_m, noise_m)));
  }
  return sample;
}

// A scan at each pose, one a second.
inline Signal ScansAt(const Building& building, const std::vector<Rigid2>& poses, double noise_m) {
  Signal signal{SignalKind::kScan, "laser", {}, {}};
  Random random(1);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    signal.samples.push_back(ScanAllAround(
        1'000'000'000LL * static_cast<std::int64_t>(i), building, poses[i], noise_m, random));
  }
  return signal;
}

// Keyscans at the times of ScansAt.
inline std::vector<StampedPose> KeyscansAt(const std::vector<Rigid2>& poses) {
  std::vector<StampedPose> keyscans;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    keyscans.push_back({1'000'000'000LL * static_cast<std::int64_t>(i), poses[i].ToRigid3()});
  }
  return keyscans;
}

// The motions between consecutive poses.
inline SensorEdges OdometryOf(const std::vector<Rigid2>& poses, double sigma_m, double sigma_rad) {
  SensorEdges edges{"laser", {}};
  const Eigen::Vector3d variances(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad);
  const std::vector<StampedPose> keyscans = KeyscansAt(poses);
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    edges.edges.push_back({EdgeKind::kOdometry,
                           keyscans[i].time_ns,
                           keyscans[i + 1].time_ns,
                           (poses[i + 1].Inverse() * poses[i]).ToRigid3(),
                           OnFloor(variances.asDiagonal())});
  }
  return edges;
}

// Poses along a closed path of straight pieces with round corners, counter-clockwise from the
// middle of the lower side of a rectangle about the origin.
inline std::vector<Rigid2> DriveAround(const Eigen::Vector2d& half_m,
                                       double radius_m,
                                       double step_m,
                                       double num_laps) {
  const double quarter_m = radius_m * std::numbers::pi / 2;
  const auto pose_at = [&](double path_m) {
    Rigid2 side{0, {0, -half_m.y()}};  // where a side is entered, from its middle on
    double to_corner_m = half_m.x() - radius_m;
    double next_m = 2 * (half_m.y() - radius_m);
    while (true) {
      if (path_m <= to_corner_m) return side * Rigid2{0, {path_m, 0}};
      path_m -= to_corner_m;
      const double turn_rad = std::min(path_m, quarter_m) / radius_m;
      side = side * Rigid2{0, {to_corner_m, 0}} *
             Rigid2{turn_rad, {radius_m * std::sin(turn_rad), radius_m * (1 - std::cos(turn_rad))}};
      if (path_m <= quarter_m) return side;
      path_m -= quarter_m;
      to_corner_m = next_m;
      next_m = 2 * (half_m.x() + half_m.y() - 2 * radius_m) - next_m;
    }
  };
  const double lap_m = 4 * (half_m.x() + half_m.y() - 2 * radius_m + quarter_m);
  std::vector<Rigid2> poses;
  for (double path_m = 0; path_m <= num_laps * lap_m; path_m += step_m) {
    poses.push_back(pose_at(path_m));
  }
  return poses;
}

}  // namespace nightmap
