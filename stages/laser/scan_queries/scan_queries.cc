// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_queries/scan_queries.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

QueryScan ScanOf(const SignalSample& sample, const Rigid2& query_from_laser) {
  return {query_from_laser, sample.value[0], sample.value[1], sample.value[2], sample.ranges_m};
}

// The scans of a robot that turned, seen from where it was at the first.
std::vector<QueryScan> TurnedScans(const ScanQueriesOptions& options, const ScanLog& log) {
  std::vector<QueryScan> scans;
  const Rigid2 first_from_odometry = log.odometry_from_robot.at(0).Inverse();
  for (std::size_t i = 0; i < log.scans.size(); ++i) {
    const Rigid2 first_from_robot = first_from_odometry * log.odometry_from_robot.at(i);
    const double way_m = first_from_robot.translation.norm();
    if (way_m > options.max_turn_m) {
      throw DataError(
          "{}: at scan {} the robot is {:.2f} m from where the log begins, more than max_turn_m = "
          "{}: cut the log to a turn on the spot, or correct `turn` in {}",
          log.name,
          i + 1,
          way_m,
          options.max_turn_m,
          log.source);
    }
    scans.push_back(ScanOf(log.scans[i], first_from_robot * log.robot_from_laser));
  }
  return scans;
}

std::string NameOf(const ScanLog& log, std::size_t scan_idx) {
  return log.scans.size() == 1 ? log.name : fmt::format("{}#{}", log.name, scan_idx + 1);
}

void Append(ScanQuery query, std::vector<ScanQuery>* queries) {
  if (!queries->empty()) query.time_ns = std::max(query.time_ns, queries->back().time_ns + 1);
  queries->push_back(std::move(query));
}

}  // namespace

std::vector<ScanQuery> RunScanQueries(const ScanQueriesOptions& options,
                                      const std::vector<ScanLog>& logs) {
  std::vector<ScanQuery> queries;
  for (const ScanLog& log : logs) {
    if (log.turn) {
      Append({log.name, log.scans.at(0).time_ns, TurnedScans(options, log), log.rough_position},
             &queries);
      continue;
    }
    for (std::size_t i = 0; i < log.scans.size(); ++i) {
      const SignalSample& scan = log.scans[i];
      Append(
          {NameOf(log, i), scan.time_ns, {ScanOf(scan, log.robot_from_laser)}, log.rough_position},
          &queries);
    }
  }
  return queries;
}

}  // namespace nightmap
