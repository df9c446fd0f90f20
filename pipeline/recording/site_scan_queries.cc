// SPDX-License-Identifier: Apache-2.0
// A [[query]] of laser scans, for site_tables.h.
#include <fmt/ranges.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/options.h"
#include "pipeline/base/plain_text.h"
#include "pipeline/recording/site_tables.h"

namespace nightmap {
namespace {

struct ScanQueryTable {
  OPTIONS_OF(ScanQueryConfig, query);
  OPTION(std::string, sensor, "", "id of the [[sensor]] of kind scan");
  REGISTER_OPTIONS();
};

// The scanner with this id; without one the only scanner.
int FindScanner(const std::vector<SensorConfig>& sensors,
                const std::string& id,
                const std::string& where) {
  std::vector<std::string> ids;
  for (const SensorConfig& sensor : sensors) {
    if (sensor.kind == SignalKind::kScan) ids.push_back(sensor.id);
  }
  if (ids.empty()) {
    throw UsageError(
        "{}: no sensor of the site scans: give the site config a [[sensor]] of kind \"scan\"",
        where);
  }
  if (id.empty() && ids.size() == 1) return FindSensor(sensors, ids[0], where);
  if (std::ranges::find(ids, id) != ids.end()) return FindSensor(sensors, id, where);
  throw UsageError("{}: sensor = \"{}\" is none of the sensors that scan: choose one of {}",
                   where,
                   id,
                   fmt::join(ids, ", "));
}

void ChooseFormat(const toml::table& table,
                  const std::vector<SignalConfig>& signals,
                  ScanQueryConfig* query) {
  if (table.contains("format") || table.contains("message")) return;
  const auto own = std::ranges::find(signals, query->sensor_idx, &SignalConfig::sensor_idx);
  if (own == signals.end()) return;
  query->format = own->format;
  query->message = own->message;
  query->columns = own->columns;
  query->time_unit = own->time_unit;
  query->rate_hz = own->rate_hz;
}

void CheckScans(const std::string& scans,
                const std::vector<ScanQueryConfig>& others,
                const std::string& where) {
  if (scans.empty() || scans.starts_with('/')) {
    throw UsageError("{}: scans = \"{}\" must be a path relative to root", where, scans);
  }
  if (!IsText(scans)) {
    throw UsageError(
        "{}: scans = \"{}\" holds control characters: rename the file", where, AsText(scans));
  }
  const auto twin = std::ranges::find(others, scans, &ScanQueryConfig::scans);
  if (twin == others.end()) return;
  throw UsageError("{}: {} asks for {} already: name it once", where, twin->source, scans);
}

// A robot that turned needs the odometry between its scans.
void CheckTurn(const ScanQueryConfig& query, const std::string& where) {
  if (!query.turn || (query.format == "carmen" && query.message != "RAWLASER1")) return;
  throw UsageError(
      "{}: turn = true needs the robot's odometry with each scan, which only FLASER, RLASER and "
      "ROBOTLASER1 lines of format \"carmen\" have: set turn = false",
      where);
}

void CheckPosition(const toml::table& table,
                   const ScanQueryConfig& query,
                   const std::string& where) {
  if (!table.contains("near_m")) return Refuse(table, {"near_radius_m"}, where, "needs near_m");
  if (query.near_m.size() != 2) {
    throw UsageError("{}: near_m has {} numbers: give x and y in the map, in metres",
                     where,
                     query.near_m.size());
  }
  if (query.near_radius_m > 0) return;
  throw UsageError("{}: near_radius_m = {} must be above 0: give the largest distance from near_m",
                   where,
                   query.near_radius_m);
}

}  // namespace

ScanQueryConfig ParseScanQuery(const toml::table& table,
                               const std::string& source,
                               const SiteConfig& site) {
  const std::string where = Where(table, source);
  ScanQueryTable parsed;
  RegisterOptions(parsed).ParseTable(table, source);
  ScanQueryConfig& query = parsed.query;
  query.source = where;
  CheckScans(query.scans, site.scan_queries, where);
  query.sensor_idx = FindScanner(site.sensors, parsed.sensor, where);
  ChooseFormat(table, site.signals, &query);
  if (query.format != "carmen") Refuse(table, {"message"}, where, "needs format = \"carmen\"");
  if (query.format != "csv") Refuse(table, {"columns"}, where, "needs format = \"csv\"");
  if (query.columns.ends_with("_ns")) query.time_unit = "ns";
  if (query.format == "csv" && query.columns.empty()) Require(table, {"columns"}, where);
  CheckTurn(query, where);
  CheckPosition(table, query, where);
  return query;
}

}  // namespace nightmap
