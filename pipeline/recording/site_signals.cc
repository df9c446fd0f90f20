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
  SensorConfig sensor;
  std::string kind = "acceleration";
  std::vector<double> robot_from_sensor;
  double start_angle_deg = -90;
  double max_range_m = kMaxRangeUnlessStated_m;
  std::string range_unit = "m";
  std::string position_unit = "m";
  std::string heading_unit = "rad";

  void Register(OptionList& list) {
    SensorConfig& s = sensor;
    list.Add("id", &s.id, "name that signals refer to");
    list.Add("kind", &kind, NamesOfKinds(), "quantity that the sensor measures");
    list.Add("robot_from_sensor", &robot_from_sensor, {-1000, 1000}, "tx ty tz (m) qx qy qz qw");
    list.Add("start_angle_deg", &start_angle_deg, {-360, 360}, "scan: first beam, from x");
    list.Add(
        "angle_step_deg", &s.angle_step_deg, {-90, 90}, "scan: 0: beams share the field of view");
    list.Add("max_range_m", &max_range_m, {0.01, 1e4}, "scan: range from which on nothing was hit");
    list.Add("min_range_m", &s.min_range_m, {0, 100}, "scan: nearer is the robot itself");
    list.Add("blind_deg", &s.blind_deg, {-360, 360}, "scan: from and to of blind sectors");
    list.Add("range_unit", &range_unit, {"m", "cm", "mm"}, "scan: unit of the ranges in its files");
    list.Add("scan_duration_s",
             &s.scan_duration_s,
             {0, kMaxScanDuration_s},
             "scan: from its first beam, whose time it states, to its end; 0: at once");
    list.Add("measures",
             &s.measures,
             {"pose", "motion", "ticks"},
             "odometry: quantity that a sample measures");
    list.Add("position_unit", &position_unit, {"m", "cm", "mm"}, "odometry: unit of its positions");
    list.Add("heading_unit", &heading_unit, {"rad", "deg"}, "odometry: unit of its headings");
    list.Add("m_per_tick", &s.m_per_tick, {0, 100}, "odometry of ticks: distance per tick, m");
    list.Add("wheel_base_m",
             &s.wheel_base_m,
             {0, 100},
             "odometry of ticks: distance between the wheels");
  }
};

struct SignalTable {
  SignalConfig signal;
  std::string sensor;

  void Register(OptionList& list) {
    SignalConfig& s = signal;
    list.Add("sensor", &sensor, "id of a [[sensor]]");
    list.Add("format", &s.format, {"text", "csv", "carmen"}, "format of the file");
    list.Add("file", &s.file, "relative to root; may be gzipped");
    list.Add(
        "columns", &s.columns, "csv: names of the columns with time and values, comma separated");
    list.Add("message",
             &s.message,
             {"", "FLASER", "RLASER", "ROBOTLASER1", "RAWLASER1", "ODOM"},
             "carmen: word that begins the lines to read");
    list.Add("time_unit", &s.time_unit, kTimeUnits, "text, csv: of its times; empty: s");
    list.Add("time_offset_s", &s.time_offset_s, {-2e9, 2e9}, "added to all times");
    list.Add("rate_hz", &s.rate_hz, {0, 1e4}, "carmen: of lines without times; 0: they have them");
    list.Add("sort", &s.sort, "sorts the samples by time");
  }
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
