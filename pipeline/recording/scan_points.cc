// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/scan_points.h"

#include <cmath>

namespace nightmap {

bool IsHit(const SignalSample& scan, float range_m) {
  return range_m > 0 && range_m < scan.value[2];  // NaN is neither
}

ScanPoints PointsInRobot(const SignalSample& scan, const Signal& signal) {
  ScanPoints result{scan.time_ns, {}};
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const float range_m = scan.ranges_m[i];
    if (!IsHit(scan, range_m)) continue;
    const double angle_rad = scan.value[0] + static_cast<double>(i) * scan.value[1];
    const Eigen::Vector3d point_in_sensor(
        range_m * std::cos(angle_rad), range_m * std::sin(angle_rad), 0);
    result.points_in_robot.push_back(signal.robot_from_sensor * point_in_sensor);
  }
  return result;
}

}  // namespace nightmap
