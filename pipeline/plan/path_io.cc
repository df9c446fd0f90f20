// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/path_io.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/json_fields.h"
#include "pipeline/plan/footprint.h"

namespace nightmap {
namespace {

constexpr const char* kPathFormat = "nightmap_path";
constexpr int kPathVersion = 3;
constexpr int kMaxFloor = 1000;
constexpr double kMaxRadius_m = 10;  // larger than the plan stage's options allow
constexpr double kMaxHole_m = 1;     // as of the plan stage's options
constexpr double kMaxHeading_rad = 3.142;
constexpr double kRounding_m = 2e-6;  // of a step between two points of the file

// Radius of the circle around the robot's centre that contains it at any heading. NaN: the config
// has none.
double RobotRadius_m(const toml::table& config) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  FootprintOptions footprint{config["robot_radius_m"].value_or(kNan), {}};
  if (const toml::array* corners = config["footprint_m"].as_array()) {
    for (const auto& number : *corners) footprint.footprint_m.push_back(number.value_or(kNan));
  }
  return std::ranges::all_of(footprint.footprint_m, [](double x_m) { return std::isfinite(x_m); })
             ? CircumscribedRadius_m(footprint)
             : kNan;
}

// The plan stage's config, which path.json carries, states the robot for which the path was
// planned.
void ReadPathConfig(const std::string& text, PlannedPath& path) {
  const toml::table config = toml::parse(text);
  path.robot_radius_m = RobotRadius_m(config);
  const auto unknown = config["unknown"].value<std::string>();
  if (!(path.robot_radius_m >= 0 && path.robot_radius_m <= kMaxRadius_m) || !unknown) {
    throw DataError("config: no robot_radius_m in [0, {}] or no unknown", kMaxRadius_m);
  }
  path.may_cross_unknown = *unknown != "forbidden";
  path.max_hole_m = config["max_hole_m"].value_or(0.0);  // an older path has none
  if (!(path.max_hole_m >= 0 && path.max_hole_m <= kMaxHole_m)) {
    throw DataError("config: max_hole_m is not in [0, {}]", kMaxHole_m);
  }
}

double Length_m(const std::vector<Eigen::Vector2d>& points) {
  double length_m = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length_m += (points[i] - points[i - 1]).norm();
  return length_m;
}

// Throws unless the figures of path.json match the points of path.csv.
void CheckFigures(const nlohmann::json& json,
                  const std::filesystem::path& csv_path,
                  std::size_t num_points,
                  const PlannedPath& path) {
  const auto check = [&](const char* field, double of_csv, double tolerance) {
    const auto of_json = json.at(field).get<double>();
    if (std::abs(of_json - of_csv) <= tolerance) return;
    throw DataError("{} is {}, but {} has {}", field, of_json, csv_path.string(), of_csv);
  };
  double length_m = 0;
  for (const auto& leg : path.legs_in_map) length_m += Length_m(leg);
  const auto num_rows = static_cast<double>(num_points);
  check("num_points", num_rows, 0);
  check("num_legs", static_cast<double>(path.legs_in_map.size()), 0);
  check("length_m", length_m, kRounding_m * num_rows);
}

void ReadPathJson(const nlohmann::json& json,
                  const std::filesystem::path& csv_path,
                  std::size_t num_points,
                  PlannedPath& path) {
  if (json.at("format") != kPathFormat) throw DataError("not a planned path");
  const int version = IntegerAt(json, "version");
  if (version != kPathVersion) {
    throw DataError("version {}, this program reads {}", version, kPathVersion);
  }
  CheckFigures(json, csv_path, num_points, path);
  path.floor = IntegerAt(json, "floor", -kMaxFloor, kMaxFloor);
  ReadPathConfig(json.at("config").get<std::string>(), path);
}

void AddPoint(const CsvRow& row, PlannedPath& path) {
  const auto leg_idx = static_cast<std::size_t>(row.Index(4));
  auto& legs = path.legs_in_map;
  if (leg_idx >= legs.size() + 1 || leg_idx + 1 < legs.size()) {
    row.Fail(fmt::format("leg_idx {} is out of order", leg_idx));
  }
  if (leg_idx == legs.size()) {
    legs.push_back(legs.empty() ? std::vector<Eigen::Vector2d>()
                                : std::vector<Eigen::Vector2d>{legs.back().back()});
  }
  legs.back().emplace_back(row.Real(0), row.Real(1));
  path.goal_heading_rad = row.Real(2);
  if (std::abs(path.goal_heading_rad) > kMaxHeading_rad) {
    row.Fail("heading_rad is not between -pi and pi: run make plan again");
  }
}

void CheckLegs(const PlannedPath& path, const std::filesystem::path& csv_path) {
  for (std::size_t i = 0; i < path.legs_in_map.size(); ++i) {
    if (Length_m(path.legs_in_map[i]) > 0) continue;
    throw DataError("{}: leg {} has no length: run make plan again", csv_path.string(), i);
  }
}

}  // namespace

PlannedPath ReadPlannedPath(const std::filesystem::path& csv_path,
                            const std::filesystem::path& json_path) {
  PlannedPath path;
  const CsvFile csv(csv_path, "x_m,y_m,heading_rad,distance_m,leg_idx", true);
  for (const CsvRow& row : csv.Rows()) AddPoint(row, path);
  if (csv.Rows().empty()) throw DataError("{}: the path has no point", csv_path.string());
  CheckLegs(path, csv_path);
  const std::string text = ReadFile(json_path);
  try {
    ReadPathJson(nlohmann::json::parse(text), csv_path, csv.Rows().size(), path);
  } catch (const toml::parse_error& error) {
    throw DataError("{}: config: {}: run make plan again", json_path.string(), error.description());
  } catch (const std::exception& error) {
    throw DataError("{}: {}: run make plan again", json_path.string(), JsonReason(error));
  }
  return path;
}

}  // namespace nightmap
