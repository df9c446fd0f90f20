// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/path_output.h"

#include <fmt/format.h>

namespace nightmap {
namespace {

nlohmann::ordered_json EndToJson(const Endpoint& endpoint) {
  const EndpointRequest& request = endpoint.request;
  return {{"request", request.text},
          {"is_picture", request.may_move},
          {"requested_x_m", request.point_in_map.x()},
          {"requested_y_m", request.point_in_map.y()},
          {"x_m", endpoint.point_in_map.x()},
          {"y_m", endpoint.point_in_map.y()},
          {"moved_by_m", endpoint.moved_by_m}};
}

}  // namespace

std::string PathToCsv(const PlanResult& result) {
  std::string csv = "x_m,y_m,heading_rad,distance_m\n";
  for (const PathPoint& point : result.path) {
    csv += fmt::format("{:.6f},{:.6f},{:.6f},{:.6f}\n",
                       point.point_in_map.x(),
                       point.point_in_map.y(),
                       point.heading_rad,
                       point.distance_m);
  }
  return csv;
}

nlohmann::ordered_json PathFigures(const PlanResult& result) {
  return {{"start", EndToJson(result.start)},
          {"goal", EndToJson(result.goal)},
          {"length_m", result.length_m},
          {"straight_line_m", (result.goal.point_in_map - result.start.point_in_map).norm()},
          {"search_cost_m", result.search_cost_m},
          {"min_clearance_m", result.min_clearance_m},
          {"num_points", result.path.size()},
          {"num_cells", result.num_cells},
          {"num_expanded_nodes", result.num_expanded}};
}

nlohmann::ordered_json PathToJson(const PlanResult& result, const std::string& config_toml) {
  nlohmann::ordered_json json = {
      {"format", "nightmap_path"}, {"version", 1}, {"units", "metres in the map frame, z up"}};
  json.update(PathFigures(result));
  json["config"] = config_toml;
  return json;
}

}  // namespace nightmap
