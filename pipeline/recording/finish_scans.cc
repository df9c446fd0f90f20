// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/finish_scans.h"

#include <cmath>
#include <numbers>

#include "pipeline/recording/scan_angles.h"
#include "pipeline/recording/scan_points.h"
#include "pipeline/recording/scan_ranges.h"

namespace nightmap {
namespace {

constexpr double kSameAngle_deg = 1e-6;

// 0 to below 360.
double WithinTurn_deg(double angle_deg) { return angle_deg - 360 * std::floor(angle_deg / 360); }

bool IsBlind(const std::vector<double>& sectors_deg, double angle_deg) {
  for (std::size_t i = 0; i + 1 < sectors_deg.size(); i += 2) {
    const double width_deg = WithinTurn_deg(sectors_deg[i + 1] - sectors_deg[i]);
    const double into_deg = WithinTurn_deg(angle_deg - sectors_deg[i] + kSameAngle_deg);
    if (into_deg <= width_deg + 2 * kSameAngle_deg) return true;
  }
  return false;
}

void LeaveOutUnmeasured(const SensorConfig& sensor, SignalSample* scan) {
  for (std::size_t i = 0; i < scan->ranges_m.size(); ++i) {
    const double angle_rad = scan->value[0] + static_cast<double>(i) * scan->value[1];
    float& range_m = scan->ranges_m[i];
    const bool is_too_near = range_m > 0 && range_m < sensor.min_range_m;
    if (is_too_near || IsBlind(sensor.blind_deg, 180 / std::numbers::pi * angle_rad)) {
      range_m = kNotMeasured_m;
    }
  }
}

}  // namespace

FoundInScans FinishScans(const SensorConfig& sensor, std::vector<SignalSample>* scans) {
  ShareCircle(sensor, scans);
  const bool is_body_stated = sensor.min_range_m > 0 || !sensor.blind_deg.empty();
  if (is_body_stated) {
    for (SignalSample& scan : *scans) LeaveOutUnmeasured(sensor, &scan);
  }
  FoundInScans found;
  if (!sensor.max_range_m) found.range_of_no_hit_m = LimitToHits(scans);
  found.body = FindRobotBody(*scans);
  found.is_body_left_out = found.body && found.body->is_certain && !is_body_stated;
  if (found.is_body_left_out) LeaveOut(*found.body, scans);
  return found;
}

}  // namespace nightmap
