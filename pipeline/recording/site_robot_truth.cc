// SPDX-License-Identifier: Apache-2.0
// [robot_truth] of a site config, for site_tables.h.
#include "pipeline/base/error.h"
#include "pipeline/recording/site_tables.h"

namespace nightmap {

RobotTruthConfig ParseRobotTruth(const toml::table& table,
                                 const std::string& source,
                                 const std::vector<SensorConfig>& sensors) {
  const std::string where = Where(table, source);
  RobotTruthConfig truth;
  RegisterOptions(truth).ParseTable(table, source);
  truth.source = where;
  if (!truth.odometry.empty() && !truth.trajectory.empty()) {
    throw UsageError("{}: the robot has one truth: remove `odometry` or `trajectory`", where);
  }
  if (truth.odometry.empty() && truth.trajectory.empty() && truth.relations.empty()) {
    throw UsageError("{}: no truth: add `odometry`, `trajectory` or `relations`", where);
  }
  if (truth.trajectory.empty()) {
    Refuse(table, {"time_unit"}, where, "is of `trajectory`");
  }
  CheckPath(truth.trajectory, "trajectory", where);
  CheckPath(truth.relations, "relations", where);
  if (truth.odometry.empty()) return truth;
  const auto idx = static_cast<std::size_t>(FindSensor(sensors, truth.odometry, where));
  if (sensors[idx].kind != SignalKind::kOdometry) {
    throw UsageError("{}: odometry = \"{}\" is a sensor of kind {}: name one of kind \"odometry\"",
                     where,
                     truth.odometry,
                     NameOf(sensors[idx].kind));
  }
  return truth;
}

}  // namespace nightmap
