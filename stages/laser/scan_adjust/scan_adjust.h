// SPDX-License-Identifier: Apache-2.0
// scan_adjust: moves the keyscans of a closed graph so that all scans that see the same walls agree
// on them.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

struct ScanAdjustOptions {
  OPTION(std::string, scan_sensor, "", "id of the sensor; empty: the only one that scans");
  OPTION(double, max_range_m, 30, {1, 500}, "points farther away are not used");
  OPTION(double, sigma_m, 0.03, {0.001, 1},
         "distance of a point from a wall beyond which it counts less and less");
  OPTION(double, first_gate_m, 0.3, {0.01, 5},
         "in the first round a point matches the nearest one up to so far away");
  OPTION(double, last_gate_m, 0.1, {0.01, 5}, "likewise in the later rounds");
  OPTION(int, num_rounds, 8, {0, 100}, "rounds of matching and solving; 0: none");
  OPTION(int, num_near_in_time, 4, {1, 20},
         "each scan is compared with so many before it: the last one, the second, fourth, eighth");
  OPTION(int, num_of_other_times, 6, {0, 100}, "and with so many of other times");
  REGISTER_OPTIONS();
};

struct ScanAdjustInput {
  std::vector<Signal> scans;          // of all sensors of the site
  std::vector<StampedPose> keyscans;  // graph_from_robot; at least one
  SensorEdges odometry;               // between consecutive keyscans, by scan_match
};

struct ScanAdjustResult {
  std::vector<StampedPose> keyscans;  // graph_from_robot; the first one stays
  std::size_t num_pairs = 0;          // of scans that were compared
  std::size_t num_matches = 0;        // points on a wall of another scan, at the end
  double rms_m = 0;                   // distance of these points from those walls
};

// Globally consistent alignment of scans (Lu, Milios, Globally consistent range scan alignment for
// environment mapping, Autonomous Robots 1997) with the point-to-line metric (Censi, An ICP variant
// using a point-to-line metric, ICRA 2008): Gauss-Newton over all keyscans at once, the matches
// chosen anew in each round, with a Cauchy kernel. Each scan is compared with some shortly before
// it and with some of other times nearby. The odometry keeps what no wall tells, as along a
// corridor. Throws UsageError when a sensor is not named but must be, InputError when keyscans,
// scans and odometry do not fit together. Deterministic at any number of threads; memory grows with
// the keyscans' walls and pairs, as the scans themselves are let go of.
ScanAdjustResult RunScanAdjust(const ScanAdjustOptions& options,
                               ScanAdjustInput input,
                               Progress& progress,
                               int num_threads);

}  // namespace nightmap
