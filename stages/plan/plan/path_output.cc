// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/path_output.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace nightmap {
namespace {

std::string SideText(const EndBox& box, ThingSide side) {
  if (!box.has_front) return "any";
  return side == ThingSide::kFront ? "front" : side == ThingSide::kOther ? "other" : "hidden";
}

nlohmann::ordered_json BoxToJson(const EndBox& box, const Endpoint& endpoint) {
  return {{"name", box.name},
          {"x_m", box.map_from_box.translation.x()},
          {"y_m", box.map_from_box.translation.y()},
          {"heading_rad", box.map_from_box.heading_rad},
          {"size_x_m", box.size_m.x()},
          {"size_y_m", box.size_m.y()},
          {"distance_m", box.Distance_m(endpoint.point_in_map)},
          {"side", SideText(box, endpoint.side)}};
}

nlohmann::ordered_json EndToJson(const PlanResult& result, const Endpoint& endpoint) {
  const EndpointRequest& request = endpoint.request;
  nlohmann::ordered_json json = {{"request", request.text},
                                 {"is_picture", request.is_picture},
                                 {"requested_x_m", request.point_in_map.x()},
                                 {"requested_y_m", request.point_in_map.y()},
                                 {"x_m", endpoint.point_in_map.x()},
                                 {"y_m", endpoint.point_in_map.y()},
                                 {"z_m", result.floor.height_m},
                                 {"moved_by_m", endpoint.moved_by_m}};
  if (request.box) json["box"] = BoxToJson(*request.box, endpoint);
  return json;
}

nlohmann::ordered_json LegToJson(const PlanResult& result, std::size_t index) {
  const PlanLeg& leg = result.legs[index];
  const Endpoint& start = result.ends[index];
  const Endpoint& goal = result.ends[index + 1];
  return {{"goal", EndToJson(result, goal)},
          {"first_point", leg.first_point},
          {"last_point", leg.last_point},
          {"length_m", leg.length_m},
          {"straight_line_m", (goal.point_in_map - start.point_in_map).norm()},
          {"search_cost_m", leg.search_cost_m},
          {"min_clearance_m", leg.min_clearance_m},
          {"num_vertices", leg.num_vertices},
          {"num_expanded_nodes", leg.num_expanded}};
}

nlohmann::ordered_json NarrowToJson(const NarrowPlace& place) {
  return {{"first_point", place.first_point},
          {"last_point", place.last_point},
          {"length_m", place.length_m},
          {"x_m", place.narrowest_in_map.x()},
          {"y_m", place.narrowest_in_map.y()},
          {"room_m", place.room_m}};
}

}  // namespace

void LogPlan(const PlanOptions& options, const PlanResult& result) {
  constexpr std::size_t kMaxPlaces = 5;
  spdlog::info("on {}, {}", FloorText(result.floor), result.floor.yaml);
  for (const Endpoint& end : result.ends) {
    spdlog::info("{} moved by {:.3f} m", EndText(end.request), end.moved_by_m);
  }
  const auto& places = result.narrow_places;
  for (std::size_t i = 0; i < std::min(places.size(), kMaxPlaces); ++i) {
    spdlog::warn(
        "the path has less than margin_m = {} of room for {:.2f} m, least {:.3f} m at "
        "{:.3f},{:.3f}: a robot needs an exact pose there",
        options.cost.margin_m,
        places[i].length_m,
        places[i].room_m,
        places[i].narrowest_in_map.x(),
        places[i].narrowest_in_map.y());
  }
  if (places.size() > kMaxPlaces) {
    spdlog::warn("it is as narrow in {} more places, see path.json", places.size() - kMaxPlaces);
  }
}

std::string PathToCsv(const PlanResult& result) {
  std::string csv = "x_m,y_m,heading_rad,distance_m,leg_idx,clearance_m,z_m,floor\n";
  for (const PathPoint& point : result.path) {
    fmt::format_to(std::back_inserter(csv),
                   "{:.6f},{:.6f},{:.6f},{:.6f},{},{:.6f},{:.6f},{}\n",
                   point.point_in_map.x(),
                   point.point_in_map.y(),
                   point.heading_rad,
                   point.distance_m,
                   point.leg_idx,
                   point.clearance_m,
                   result.floor.height_m,
                   result.floor.number);
  }
  return csv;
}

std::string PathToNavYaml(const PlanResult& result) {
  std::string yaml = fmt::format("# {}\n", FloorText(result.floor));
  yaml += "header:\n  stamp: {sec: 0, nanosec: 0}\n  frame_id: map\nposes:\n";
  for (const PathPoint& point : result.path) {
    fmt::format_to(std::back_inserter(yaml),
                   "- header: {{stamp: {{sec: 0, nanosec: 0}}, frame_id: map}}\n"
                   "  pose:\n"
                   "    position: {{x: {:.6f}, y: {:.6f}, z: {:.6f}}}\n"
                   "    orientation: {{x: 0.0, y: 0.0, z: {:.9f}, w: {:.9f}}}\n",
                   point.point_in_map.x(),
                   point.point_in_map.y(),
                   result.floor.height_m,
                   std::sin(point.heading_rad / 2),
                   std::cos(point.heading_rad / 2));
  }
  return yaml;
}

nlohmann::ordered_json PathFigures(const PlanResult& result) {
  PlanLeg total = result.legs.front();
  auto legs = nlohmann::ordered_json::array();
  auto narrow = nlohmann::ordered_json::array();
  for (const NarrowPlace& place : result.narrow_places) narrow.push_back(NarrowToJson(place));
  for (std::size_t i = 0; i < result.legs.size(); ++i) {
    legs.push_back(LegToJson(result, i));
    if (i == 0) continue;
    const PlanLeg& leg = result.legs[i];
    total.length_m += leg.length_m;
    total.min_clearance_m = std::min(total.min_clearance_m, leg.min_clearance_m);
    total.search_cost_m += leg.search_cost_m;
    total.num_expanded += leg.num_expanded;
  }
  return {{"floor", result.floor.number},
          {"floor_height_m", result.floor.height_m},
          {"start", EndToJson(result, result.ends.front())},
          {"goal", EndToJson(result, result.ends.back())},
          {"length_m", total.length_m},
          {"search_cost_m", total.search_cost_m},
          {"min_clearance_m", total.min_clearance_m},
          {"num_points", result.path.size()},
          {"num_expanded_nodes", total.num_expanded},
          {"num_hole_cells", result.num_hole_cells},
          {"narrow_places", narrow},
          {"num_legs", result.legs.size()},
          {"legs", legs}};
}

nlohmann::ordered_json PathToJson(const PlanResult& result, const std::string& config_toml) {
  nlohmann::ordered_json json = {
      {"format", "nightmap_path"}, {"version", 3}, {"units", "metres in the map frame, z up"}};
  json.update(PathFigures(result));
  json["config"] = config_toml;
  return json;
}

}  // namespace nightmap
