// SPDX-License-Identifier: Apache-2.0
// [[sensor]] and [[signal]] of a site config, for site_tables.h.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/base/options.h"
#include "pipeline/recording/site_tables.h"

namespace nightmap {
namespace {

std::vector<std::string> NamesOfKinds() {
  std::vector<std::string> names;
  for (const SignalKindRow& row : SignalKinds()) names.push_back(row.name);
  return names;
}

struct SensorTable {
  OPTIONS_OF(SensorConfig, sensor);
  OPTION(std::string, kind, "acceleration", NamesOfKinds(), "quantity that the sensor measures");
  OPTION(std::vector<double>, robot_from_sensor, {}, {-1000, 1000}, "tx ty tz (m) qx qy qz qw");
  OPTION(double, start_angle_deg, -90, {-360, 360}, "scan: first beam, from x");
  OPTION(double, max_range_m, kMaxRangeUnlessStated_m, {0.01, 1e4},
         "scan: range from which on nothing was hit");
  OPTION(std::string, range_unit, "m", {"m", "cm", "mm"}, "scan: unit of the ranges in its files");
  OPTION(std::string, position_unit, "m", {"m", "cm", "mm"}, "odometry: unit of its positions");
  OPTION(std::string, heading_unit, "rad", {"rad", "deg"}, "odometry: unit of its headings");
  REGISTER_OPTIONS();
};

struct SignalTable {
  OPTIONS_OF(SignalConfig, signal);
  OPTION(std::string, sensor, "", "id of a [[sensor]]");
  REGISTER_OPTIONS();
};

void CheckSectors(const std::vector<double>& sectors_deg, const std::string& where) {
  bool is_right = sectors_deg.size() % 2 == 0;
  for (std::size_t i = 0; is_right && i < sectors_deg.size(); i += 2) {
    is_right = std::abs(std::remainder(sectors_deg[i + 1] - sectors_deg[i], 360)) > 1e-3;
  }
  if (is_right) return;
  throw UsageError(
      "{}: blind_deg = [{}] must have from and to of each sector, as [135, 225], and no sector is "
      "empty or a whole circle",
      where,
      fmt::join(sectors_deg, ", "));
}

double UnitInM(const std::string& unit) { return unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1; }

// Values that a scanner does not state are in its lines, or follow from the number of beams. They
// follow for beams that begin at the right and are symmetric about x.
void TakeStated(const toml::table& table,
                const SensorTable& parsed,
                const std::string& where,
                SensorConfig* sensor) {
  sensor->range_unit_m = UnitInM(parsed.range_unit);
  sensor->position_unit_m = UnitInM(parsed.position_unit);
  if (table.contains("heading_unit")) {
    sensor->heading_unit_rad = parsed.heading_unit == "deg" ? std::numbers::pi / 180 : 1;
  }
  if (table.contains("max_range_m")) sensor->max_range_m = parsed.max_range_m;
  if (!table.contains("start_angle_deg")) return;
  sensor->start_angle_deg = parsed.start_angle_deg;
  if (sensor->angle_step_deg != 0) return;
  if (parsed.start_angle_deg < 0 && parsed.start_angle_deg >= -180) return;
  throw UsageError(
      "{}: start_angle_deg = {} tells no field of view, as one from -180 to below 0 does: add "
      "angle_step_deg (negative: clockwise)",
      where,
      parsed.start_angle_deg);
}

// The message must hold the quantity that the sensor measures.
void CheckMessage(const SignalConfig& signal, SignalKind kind, const std::string& where) {
  const bool has_scan = signal.message != "ODOM";
  const bool has_odometry = signal.message != "RAWLASER1";
  if (kind == SignalKind::kScan ? has_scan : kind == SignalKind::kOdometry && has_odometry) return;
  throw UsageError("{}: message = \"{}\" holds no {}: correct `message` or `sensor`",
                   where,
                   signal.message,
                   NameOf(kind));
}

}  // namespace

int FindSensor(const std::vector<SensorConfig>& sensors,
               const std::string& id,
               const std::string& where) {
  const auto found = std::ranges::find(sensors, id, &SensorConfig::id);
  if (found != sensors.end()) return static_cast<int>(found - sensors.begin());
  std::vector<std::string> ids;
  for (const SensorConfig& sensor : sensors) ids.push_back(sensor.id);
  throw UsageError(
      "{}: no [[sensor]] has id \"{}\"; there are: {}", where, id, fmt::join(ids, ", "));
}

SensorConfig ParseSensor(const toml::table& table, const std::string& source) {
  const std::string where = Where(table, source);
  SensorTable parsed;
  RegisterOptions(parsed).ParseTable(table, source);
  Require(table, {"id", "kind"}, where);
  SensorConfig& sensor = parsed.sensor;
  sensor.kind = *KindOf(parsed.kind);
  if (sensor.id.empty()) throw UsageError("{}: id is empty: name the sensor", where);
  if (sensor.kind != SignalKind::kScan) {
    Refuse(table,
           {"start_angle_deg",
            "angle_step_deg",
            "max_range_m",
            "range_unit",
            "scan_duration_s",
            "min_range_m",
            "blind_deg"},
           where,
           "is of a scan");
  }
  if (sensor.kind != SignalKind::kOdometry) {
    Refuse(table, {"measures", "position_unit", "heading_unit"}, where, "is of odometry");
  }
  if (sensor.measures == "ticks") {
    if (sensor.m_per_tick <= 0 || sensor.wheel_base_m <= 0) {
      throw UsageError("{}: ticks need m_per_tick and wheel_base_m, both above 0", where);
    }
    Refuse(table, {"position_unit", "heading_unit"}, where, "does not go with ticks");
  } else {
    Refuse(table, {"m_per_tick", "wheel_base_m"}, where, "needs measures = \"ticks\"");
  }
  CheckSectors(sensor.blind_deg, where);
  TakeStated(table, parsed, where, &sensor);
  if (table.contains("robot_from_sensor")) {
    sensor.robot_from_sensor = ToPose(parsed.robot_from_sensor, "robot_from_sensor", where);
  }
  return sensor;
}

SignalConfig ParseSignal(const toml::table& table,
                         const std::string& source,
                         const std::vector<SensorConfig>& sensors) {
  const std::string where = Where(table, source);
  SignalTable parsed;
  RegisterOptions(parsed).ParseTable(table, source);
  Require(table, {"sensor", "format", "file"}, where);
  SignalConfig& signal = parsed.signal;
  signal.source = where;
  signal.sensor_idx = FindSensor(sensors, parsed.sensor, where);
  CheckPath(signal.file, "file", where);
  const SignalKind kind = sensors[static_cast<std::size_t>(signal.sensor_idx)].kind;
  if (signal.format == "carmen") {
    Require(table, {"message"}, where);
    CheckMessage(signal, kind, where);
    Refuse(table, {"time_unit"}, where, "does not go with format = \"carmen\": it has seconds");
  } else {
    Refuse(table, {"message", "rate_hz"}, where, "needs format = \"carmen\"");
  }
  if (signal.format == "csv") {
    Require(table, {"columns"}, where);
    if (signal.columns.substr(0, signal.columns.find(',')).ends_with("_ns")) {
      Refuse(table, {"time_unit"}, where, "is stated by the name of the first column");
      signal.time_unit = "ns";
    }
    if (kind == SignalKind::kScan && signal.columns.find(',') != std::string::npos) {
      throw UsageError(
          "{}: columns = \"{}\" must name the time alone: of a scan all other columns "
          "of the file are ranges",
          where,
          signal.columns);
    }
  } else {
    Refuse(table, {"columns"}, where, "needs format = \"csv\"");
  }
  return signal;
}

}  // namespace nightmap
