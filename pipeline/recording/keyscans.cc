// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/keyscans.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/input_error.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/scan_points.h"

namespace nightmap {
namespace {

constexpr std::int64_t kMaxGap_ns = 1'000'000'000;  // between keyscans of a robot that moves

// The points of a scan. One that takes a while is corrected by the motion towards the next keyscan.
ScanPoints PointsOf(const SignalSample& scan,
                    const Signal& scans,
                    const StampedPose& pose,
                    const std::vector<StampedPose>& poses) {
  if (scans.scan_duration_s <= 0) return PointsInRobot(scan, scans);
  const std::int64_t end_ns = pose.time_ns + std::llround(1e9 * scans.scan_duration_s);
  const auto start_from_end = PoseAt(poses, end_ns, kMaxGap_ns);
  if (!start_from_end) return PointsInRobot(scan, scans);
  return PointsInRobot(scan, scans, pose.pose.Inverse() * *start_from_end);
}

}  // namespace

std::vector<Eigen::Vector2d> PointsOfKeyscan(const Signal& scans,
                                             const std::vector<StampedPose>& keyscans,
                                             std::size_t i,
                                             double max_range_m) {
  const StampedPose& keyscan = keyscans[i];
  const auto scan =
      std::ranges::lower_bound(scans.samples, keyscan.time_ns, {}, &SignalSample::time_ns);
  if (scan == scans.samples.end() || scan->time_ns != keyscan.time_ns) {
    throw InputError({{"keyframes"}, {"scans"}},
                     "there is a keyscan and no scan at {} s",
                     TimeToString(keyscan.time_ns));
  }
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3d& point : PointsOf(*scan, scans, keyscan, keyscans).points_in_robot) {
    if (point.head<2>().norm() <= max_range_m) points.push_back(point.head<2>());
  }
  return points;
}

void CheckEdgesOfKeyscans(const std::vector<StampedPose>& keyscans,
                          const std::vector<SensorEdge>& edges) {
  bool fits = edges.size() + 1 == keyscans.size();
  for (std::size_t i = 0; fits && i < edges.size(); ++i) {
    fits = edges[i].source_time_ns == keyscans[i].time_ns &&
           edges[i].target_time_ns == keyscans[i + 1].time_ns;
  }
  if (!fits) throw InputError({{"odometry"}, {"keyframes"}}, "their keyscans differ");
}

}  // namespace nightmap
