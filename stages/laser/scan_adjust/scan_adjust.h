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
  std::string scan_sensor;
  double max_range_m = 30;
  double spacing_m = 0.05;
  double sigma_m = 0.03;
  double first_gate_m = 0.3;
  double last_gate_m = 0.1;
  int num_rounds = 8;
  double neighbour_distance_m = 3;
  int num_near_in_time = 4;
  int num_of_other_times = 6;

  void Register(OptionList& list);
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
// scans and odometry do not fit together. Deterministic at any number of threads.
ScanAdjustResult RunScanAdjust(const ScanAdjustOptions& options,
                               const ScanAdjustInput& input,
                               Progress& progress,
                               int num_threads);

}  // namespace nightmap
