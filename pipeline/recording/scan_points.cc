// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/scan_points.h"

#include <cmath>

namespace nightmap {

bool IsHit(const SignalSample& scan, float range_m) {
  return range_m > 0 && range_m < scan.value[2];  // NaN is neither
}

namespace {

// start_from_robot(share of the scan that is over, point_in_robot) is the point from its start.
template <typename StartFromRobot>
ScanPoints PointsOf(const SignalSample& scan,
                    const Signal& signal,
                    const StartFromRobot& start_from_robot) {
  ScanPoints result{scan.time_ns, {}};
  const auto num_beams = static_cast<double>(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const float range_m = scan.ranges_m[i];
    if (!IsHit(scan, range_m)) continue;
    const double angle_rad = scan.value[0] + static_cast<double>(i) * scan.value[1];
    const Eigen::Vector3d point_in_sensor(
        range_m * std::cos(angle_rad), range_m * std::sin(angle_rad), 0);
    result.points_in_robot.push_back(start_from_robot(static_cast<double>(i) / num_beams,
                                                      signal.robot_from_sensor * point_in_sensor));
  }
  return result;
}

}  // namespace

ScanPoints PointsInRobot(const SignalSample& scan, const Signal& signal) {
  return PointsOf(
      scan, signal, [](double, const Eigen::Vector3d& point_in_robot) { return point_in_robot; });
}

ScanPoints PointsInRobot(const SignalSample& scan,
                         const Signal& signal,
                         const Rigid3& start_from_end) {
  return PointsOf(scan, signal, [&](double share, const Eigen::Vector3d& point_in_robot) {
    const Rigid3 start_from_robot{
        Eigen::Quaterniond::Identity().slerp(share, start_from_end.rotation),
        share * start_from_end.translation};
    return start_from_robot * point_in_robot;
  });
}

ScannerFromAbove SeenFromAbove(const Rigid3& robot_from_sensor) {
  const Eigen::Matrix3d axes_in_robot = robot_from_sensor.rotation.toRotationMatrix();
  const double heading_rad = std::atan2(axes_in_robot(1, 0), axes_in_robot(0, 0));
  return {{heading_rad, robot_from_sensor.translation.head<2>()}, axes_in_robot(2, 2) < 0};
}

}  // namespace nightmap
