// SPDX-License-Identifier: Apache-2.0
// hold_out_scans: keeps stretches of a robot's way out of a map, to ask where their scans are.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/laser/scan_queries_io.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

struct HoldOutScansOptions {
  OPTION(std::string, sensor, "", "id of the sensor; empty: the only one that scans");
  OPTION(double, block_m, 10, {0.1, 1000}, "path of a block, the piece that is held out");
  OPTION(int, every, 3, {2, 1000}, "each so manieth block is held out");
  OPTION(int, max_queries, 250, {1, 1e6}, "most queries; others are left out evenly");
  OPTION(double, near_m, 1, {0.01, 1000}, "a query has a scan that stays within this");
  OPTION(double, rough_radius_m, 0, {0, 1000},
         "gives each query a position that is off by up to this; 0: none");
  OPTION(int, seed, 1, {0, 1e9}, "of these positions");
  REGISTER_OPTIONS();
};

struct HoldOutScansInput {
  std::vector<Signal> scans;            // of every sensor that scans
  std::vector<StampedPose> trajectory;  // map_from_robot at the scans; times increase
};

struct HeldOutScans {
  std::vector<Signal> mapped;      // the scanner with the scans that stay
  std::vector<ScanQuery> queries;  // named by their time in seconds
  std::vector<StampedPose> truth;  // map_from_robot of each query
  std::size_t num_held_out = 0;    // scans of the blocks
  std::size_t num_far = 0;         // of them, those farther than near_m from the map
  std::size_t num_left_out = 0;    // queries beyond max_queries
};

// Cuts the way into blocks of block_m, and takes each `every`-th of them out of the map. Its scans
// become queries, half a metre apart on the way, where a scan that stays is within near_m:
// elsewhere nobody can ask the map. From more than max_queries, some are left out evenly: the time
// that looking for them takes does not grow with the way. A scan without a pose stays. Scans are
// taken at once: the motion within one (scan_duration_s) is left out of account in queries. With a
// rough_radius_m each query comes with a position drawn evenly from the disc of that radius around
// the true one. A way that is short, or leads nowhere twice, leaves no query. Deterministic. Throws
// UsageError when `sensor` names none, or none among several, InputError of the port `scans` when
// nothing scans.
HeldOutScans RunHoldOutScans(const HoldOutScansOptions& options, const HoldOutScansInput& input);

}  // namespace nightmap
