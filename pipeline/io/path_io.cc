// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/path_io.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"

namespace nightmap {
namespace {

constexpr const char* kPathFormat = "nightmap_path";
constexpr int kPathVersion = 3;
constexpr double kMaxRadius_m = 10;  // more than the plan stage's options allow
constexpr double kMaxHeading_rad = 3.142;
constexpr double kRounding_m = 2e-6;  // of a step between two points of the file

// Of the circle about the robot's centre that it stays in however it turns.
double RobotRadius_m(const toml::table& config) {
  double radius_m = config["robot_radius_m"].value_or(-1.0);
  const toml::array* corners = config["footprint_m"].as_array();
  if (!corners || corners->empty()) return radius_m;
  radius_m = 0;
  for (std::size_t i = 0; i + 1 < corners->size(); i += 2) {
    const double x_m = (*corners)[i].value_or(-1.0);
    const double y_m = (*corners)[i + 1].value_or(-1.0);
    radius_m = std::max(radius_m, std::hypot(x_m, y_m));
  }
  return radius_m;
}

// What the path was planned for is in the plan stage's config, which path.json carries.
void ReadPathConfig(const std::string& text, const std::string& name, PlannedPath& path) {
  const toml::table config = toml::parse(text);
  path.robot_radius_m = RobotRadius_m(config);
  const auto unknown = config["unknown"].value<std::string>();
  if (!(path.robot_radius_m >= 0 && path.robot_radius_m <= kMaxRadius_m) || !unknown) {
    throw DataError("{}: config: no robot_radius_m in [0, {}] or no unknown: run make plan again",
                    name,
                    kMaxRadius_m);
  }
  path.may_cross_unknown = *unknown != "forbidden";
}

double Length_m(const std::vector<Eigen::Vector2d>& points) {
  double length_m = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length_m += (points[i] - points[i - 1]).norm();
  return length_m;
}

void CheckSame(
    const std::string& name, const char* field, double of_json, double of_csv, double tolerance) {
  if (std::abs(of_json - of_csv) <= tolerance) return;
  throw DataError(
      "{}: {} is {}, but path.csv has {}: run make plan again", name, field, of_json, of_csv);
}

void CheckFigures(const nlohmann::json& json,
                  const std::string& name,
                  std::size_t num_points,
                  const PlannedPath& path) {
  const auto of_json = [&](const char* field) { return json.at(field).get<double>(); };
  const auto num_rows = static_cast<double>(num_points);
  double length_m = 0;
  for (const auto& leg : path.legs_in_map) length_m += Length_m(leg);
  CheckSame(name, "num_points", of_json("num_points"), num_rows, 0);
  CheckSame(name, "num_legs", of_json("num_legs"), static_cast<double>(path.legs_in_map.size()), 0);
  CheckSame(name, "length_m", of_json("length_m"), length_m, kRounding_m * num_rows);
}

void ReadPathJson(const std::filesystem::path& json_path,
                  std::size_t num_points,
                  PlannedPath& path) {
  const std::string name = json_path.string();
  try {
    const auto json = nlohmann::json::parse(ReadFile(json_path));
    if (json.at("format") != kPathFormat) throw DataError("{}: not a planned path", name);
    const int version = json.at("version").get<int>();
    if (version != kPathVersion) {
      throw DataError("{}: version {}, this program reads {}: run make plan again",
                      name,
                      version,
                      kPathVersion);
    }
    CheckFigures(json, name, num_points, path);
    path.floor = json.at("floor").get<int>();
    ReadPathConfig(json.at("config").get<std::string>(), name, path);
  } catch (const nlohmann::json::exception& error) {
    throw DataError("{}: {}", name, error.what());
  } catch (const toml::parse_error& error) {
    throw DataError("{}: config: {}", name, error.description());
  }
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

void CheckLegs(const PlannedPath& path) {
  for (std::size_t i = 0; i < path.legs_in_map.size(); ++i) {
    if (Length_m(path.legs_in_map[i]) > 0) continue;
    throw DataError("{}: leg {} has no length: run make plan again", path.source, i);
  }
}

}  // namespace

PlannedPath ReadPlannedPath(const std::filesystem::path& csv_path,
                            const std::filesystem::path& json_path) {
  PlannedPath path;
  path.source = csv_path.string();
  const CsvFile csv(csv_path, "x_m,y_m,heading_rad,distance_m,leg_idx", true);
  for (const CsvRow& row : csv.Rows()) AddPoint(row, path);
  if (csv.Rows().empty()) throw DataError("{}: the path has no point", csv_path.string());
  CheckLegs(path);
  ReadPathJson(json_path, csv.Rows().size(), path);
  return path;
}

}  // namespace nightmap
