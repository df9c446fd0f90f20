// SPDX-License-Identifier: Apache-2.0
// scan_queries: lists the laser scans to locate in a site's map, those of [[query]] tables.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/laser/scan_queries_io.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

struct ScanQueriesOptions {
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the lines of a log is no scan");
  OPTION(double, max_turn_m, 1, {0, 100},
         "fails when a robot that turned on the spot went farther from its first scan");
  REGISTER_OPTIONS();
};

// The scans of one [[query]], in the order of its log.
struct ScanLog {
  std::string name;    // path of the log as the config has it
  std::string source;  // file:line of the table, for messages
  Rigid2 robot_from_laser;
  std::vector<SignalSample> scans;          // at least one; times in any order
  bool turn = false;                        // they are one query
  std::vector<Rigid2> odometry_from_robot;  // at each scan, for a robot that turned
  std::optional<RoughPosition> rough_position;
};

// Each scan is a query, named after its log; #1, #2 ... tell several of one log apart. The scans of
// a robot that turned are one query, in the frame of the robot at the first one. Queries keep the
// order of the logs and their scans; a time that is not after the one before becomes that and 1 ns.
// A scan is taken at once: the motion within one (scan_duration_s) is left out of account. Pure and
// deterministic. Throws DataError when a robot that turned went farther than max_turn_m.
std::vector<ScanQuery> RunScanQueries(const ScanQueriesOptions& options,
                                      const std::vector<ScanLog>& logs);

}  // namespace nightmap
