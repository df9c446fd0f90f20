// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/path_io.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"

namespace nightmap {
namespace {

constexpr const char* kPathFormat = "nightmap_path";
constexpr int kPathVersion = 1;

// The numbers of the plan stage's options are in its config, which path.json carries.
void ReadPathConfig(const std::string& config, const std::string& name, PlannedPath& path) {
  const toml::table table = toml::parse(config);
  path.robot_radius_m = table["robot_radius_m"].value<double>();
  path.may_cross_unknown = !table["unknown_is_obstacle"].value_or(true) ||
                           table["unknown"].value_or(std::string("forbidden")) != "forbidden";
  if (path.robot_radius_m && !(std::isfinite(*path.robot_radius_m) && *path.robot_radius_m >= 0)) {
    throw DataError("{}: config: robot_radius_m is {}", name, *path.robot_radius_m);
  }
}

void ReadPathJson(const std::filesystem::path& json_path, PlannedPath& path) {
  const std::string name = json_path.string();
  try {
    const auto json = nlohmann::json::parse(ReadFile(json_path));
    if (json.at("format") != kPathFormat) throw DataError("{}: not a planned path", name);
    const int version = json.at("version").get<int>();
    if (version > kPathVersion) {
      throw DataError("{}: version {} is newer than this program's {}: rebuild it",
                      name,
                      version,
                      kPathVersion);
    }
    const auto num_points = json.at("num_points").get<std::size_t>();
    if (num_points != path.points_in_map.size()) {
      throw DataError("{}: num_points is {}, but path.csv has {}: run make plan again",
                      name,
                      num_points,
                      path.points_in_map.size());
    }
    ReadPathConfig(json.at("config").get<std::string>(), name, path);
  } catch (const nlohmann::json::exception& error) {
    throw DataError("{}: {}", name, error.what());
  } catch (const toml::parse_error& error) {
    throw DataError("{}: config: {}", name, error.description());
  }
}

}  // namespace

PlannedPath ReadPlannedPath(const std::filesystem::path& csv_path,
                            const std::filesystem::path& json_path) {
  PlannedPath path;
  const CsvFile csv(csv_path, "x_m,y_m,heading_rad,distance_m", true);
  for (const CsvRow& row : csv.Rows()) {
    path.points_in_map.emplace_back(row.Real(0), row.Real(1));
    path.goal_heading_rad = row.Real(2);
  }
  if (path.points_in_map.empty()) throw DataError("{}: the path has no point", csv_path.string());
  ReadPathJson(json_path, path);
  return path;
}

}  // namespace nightmap
