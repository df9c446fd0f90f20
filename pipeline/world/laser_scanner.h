// SPDX-License-Identifier: Apache-2.0
// A 2-D laser scanner on the robot: level, upright, above the robot's origin.
//
// Beam i of n points at field_of_view * (i / n - 1/2), counter-clockwise from the robot's x, at the
// time of the scan plus i / n of duration_s. So the stamp is the time of the first beam, as in ROS
// (sensor_msgs/LaserScan), and the robot moves while it scans.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/world/robot_drive.h"
#include "pipeline/world/synthetic_options.h"
#include "pipeline/world/synthetic_world.h"
#include "pipeline/world/walkers.h"

namespace nightmap {

// Measures the nearest surface or leg. A beam has the range max_range_m, because nothing returns,
// - from beyond max_range_m
// - from glass: the share glass_ratio of the stretches, 1 m long, of walls and doors
// - from black beyond black_range_m: surfaces of a dark tint, and the share black_ratio of others
// - by chance: the share miss_ratio of all beams.
// The robot is level on a ramp too, where its beams may hit the ramp. Thread safe.
class LaserScanner {
 public:
  // `building_seed` decides which surfaces are glass and black. `world` outlives the scanner.
  LaserScanner(const SyntheticWorld& world,
               std::vector<Walker> walkers,
               const ScannerOptions& options,
               std::uint64_t building_seed);

  // Ranges (m), one per beam, of the scan that begins at `time_s` of the drive. The noise depends
  // on noise_seed alone, so give each scan its own.
  std::vector<float> Scan(const RobotDrive& drive, double time_s, std::uint64_t noise_seed) const;

 private:
  double ExactRange_m(const RoutePoint& robot, double bearing_rad, double time_s) const;
  bool IsGlass(const RayHit& hit) const;
  bool IsBlack(const RayHit& hit) const;

  const SyntheticWorld& world_;
  std::vector<Walker> walkers_;
  ScannerOptions options_;
  std::uint64_t building_seed_;
};

}  // namespace nightmap
