// SPDX-License-Identifier: Apache-2.0
// Hits of a laser scanner, as points.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

// The range of a beam that measured nothing of the building: it lies in a blind sector, or ended on
// the robot. It is no hit, and no beam that hit nothing either, so nothing is free along it.
inline constexpr float kNotMeasured_m = -1;

// Whether a beam hit something: its range is positive and below the scan's limit. Where a scanner
// hit nothing it reports zero, NaN, the limit or more; below zero, nothing was measured.
bool IsHit(const SignalSample& scan, float range_m);

struct ScanPoints {
  std::int64_t time_ns = 0;
  std::vector<Eigen::Vector3d> points_in_robot;  // metres; hits only, in the order of the beams
};

// Points of a sample of `signal`, a sensor that scans. Beam i points at first angle + i * step,
// counter-clockwise from the sensor's x in its plane z = 0. Pure.
ScanPoints PointsInRobot(const SignalSample& scan, const Signal& signal);

// Likewise, seen from where the robot is at the scan's time. Meanwhile it moves: start_from_end is
// its motion over signal.scan_duration_s, at constant speed along a straight line while it turns.
ScanPoints PointsInRobot(const SignalSample& scan,
                         const Signal& signal,
                         const Rigid3& start_from_end);

// A scanner as seen from above: where it stands and looks on the floor, and whether its angles
// count the other way there, because it hangs upside down. Pure.
struct ScannerFromAbove {
  Rigid2 robot_from_laser;
  bool is_upside_down = false;
};
ScannerFromAbove SeenFromAbove(const Rigid3& robot_from_sensor);

}  // namespace nightmap
