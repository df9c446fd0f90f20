// SPDX-License-Identifier: Apache-2.0
// laser_grid: makes the occupancy grid of a floor from the scans of a laser scanner.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/laser/scan_grid.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

struct LaserGridOptions {
  OPTION(std::string, sensor, "", "id of the sensor; empty: the only one that scans");
  OPTION(double, max_gap_s, 0.5, {0, 10},
         "uses a scan between two poses only if they are at most this far apart");
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the scans has no pose");
  OPTIONS_OF(ScanGridOptions, grid);
  REGISTER_OPTIONS();
};

struct LaserGridInput {
  std::vector<Signal> scans;            // of every sensor that scans
  std::vector<StampedPose> trajectory;  // map_from_robot; times increase
};

struct LaserGridResult {
  ScanGrid map;
  std::string sensor_id;
  std::size_t num_scans = 0;         // of the sensor
  std::vector<std::string> skipped;  // "scan at TIME: cause", one for each scan without a pose
};

// Places each scan at the robot's pose at its time and fills the grid as GridOfScans does. Between
// two poses at most max_gap_s apart the pose is interpolated; a scan with no such poses is skipped.
// Each beam of a scan that takes a while (scan_duration_s) is placed at its own time; where the
// trajectory ends before the scan does, all are at the scan's.
// Throws UsageError when `sensor` names none, or none while there are several; InputError naming
// the remedy when no sensor scans, no scan has a pose, or no beam hit anything. Deterministic.
LaserGridResult RunLaserGrid(const LaserGridOptions& options, const LaserGridInput& input);

// Figures for report.json.
nlohmann::json DescribeLaserGrid(const LaserGridResult& result);

}  // namespace nightmap
