// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/drive_output.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

namespace nightmap {

std::string DriveToCsv(const DriveResult& result) {
  const auto period_ns = static_cast<std::int64_t>(std::llround(result.period_s * 1e9));
  std::string csv = "time_ns,x_m,y_m,heading_rad,v_m_s,omega_rad_s\n";
  std::int64_t time_ns = 0;
  for (const DriveStep& step : result.steps) {
    csv += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f}\n",
                       time_ns,
                       step.pose.point_in_map.x(),
                       step.pose.point_in_map.y(),
                       step.pose.heading_rad,
                       step.command.v_m_s,
                       step.command.omega_rad_s);
    time_ns += period_ns;
  }
  return csv;
}

nlohmann::ordered_json DriveFigures(const DriveResult& result) {
  return {{"floor", result.floor},
          {"duration_s", result.Duration_s()},
          {"length_m", result.length_m},
          {"path_length_m", result.path_length_m},
          {"max_deviation_m", result.max_deviation_m},
          {"min_clearance_m", result.min_clearance_m},
          {"position_error_m", result.position_error_m},
          {"heading_error_deg", result.heading_error_deg},
          {"robot_radius_m", result.footprint.radius_m},
          {"unknown_is_obstacle", result.footprint.unknown_is_obstacle},
          {"max_hole_m", result.footprint.max_hole_m},
          {"period_s", result.period_s},
          {"num_goals", result.num_goals},
          {"num_steps", result.steps.size()}};
}

nlohmann::ordered_json DriveToJson(const DriveResult& result, const std::string& config_toml) {
  nlohmann::ordered_json json = {
      {"format", "nightmap_drive"}, {"version", 1}, {"units", "metres in the map frame, z up"}};
  json.update(DriveFigures(result));
  json["config"] = config_toml;
  return json;
}

}  // namespace nightmap
