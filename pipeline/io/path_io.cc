// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/path_io.h"

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

namespace nightmap {
namespace {

constexpr const char* kPathFormat = "nightmap_path";
constexpr int kPathVersion = 3;
constexpr int kMaxFloor = 1000;

// Radius of the circle about the robot's centre that it stays in however it turns. NaN: the config
// has none.
double RobotRadius_m(const toml::table& config) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  double radius_m = config["robot_radius_m"].value_or(kNan);
  const toml::array* corners = config["footprint_m"].as_array();
  if (!corners || corners->empty()) return radius_m;
  radius_m = 0;
  for (std::size_t i = 0; i + 1 < corners->size(); i += 2) {
    const double x_m = (*corners)[i].value_or(kNan);
    const double y_m = (*corners)[i + 1].value_or(kNan);
    if (!std::isfinite(x_m) || !std::isfinite(y_m)) return kNan;
    radius_m = std::max(radius_m, std::hypot(x_m, y_m));
  }
  return radius_m;
}

// What the path was planned for is in the plan stage's config, which path.json carries.
void ReadPathConfig(const std::string& text, PlannedPath& path) {
  const toml::table config = toml::parse(text);
  path.robot_radius_m = RobotRadius_m(config);
  const auto unknown = config["unknown"].value<std::string>();
  if (!(std::isfinite(path.robot_radius_m) && path.robot_radius_m >= 0) || !unknown) {
    throw DataError("config: no robot_radius_m or unknown");
  }
  path.may_cross_unknown = *unknown != "forbidden";
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
  const auto num_written = static_cast<std::size_t>(IntegerAt(json, "num_points"));
  if (num_written != num_points) {
    throw DataError("num_points is {}, but {} has {}", num_written, csv_path.string(), num_points);
  }
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
}

}  // namespace

PlannedPath ReadPlannedPath(const std::filesystem::path& csv_path,
                            const std::filesystem::path& json_path) {
  PlannedPath path;
  const CsvFile csv(csv_path, "x_m,y_m,heading_rad,distance_m,leg_idx", true);
  for (const CsvRow& row : csv.Rows()) AddPoint(row, path);
  if (csv.Rows().empty()) throw DataError("{}: the path has no point", csv_path.string());
  const std::string text = ReadFile(json_path);
  try {
    ReadPathJson(nlohmann::json::parse(text), csv_path, csv.Rows().size(), path);
  } catch (const toml::parse_error& error) {
    throw DataError("{}: config: {}: run make plan again", json_path.string(), error.description());
  } catch (const std::exception& error) {
    throw DataError("{}: {}: run make plan again", json_path.string(), error.what());
  }
  return path;
}

}  // namespace nightmap
