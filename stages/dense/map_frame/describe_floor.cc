// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/describe_floor.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "stages/dense/map_frame/choose_up.h"

namespace nightmap {

std::string DescribeFloor(const MapFrame& frame) {
  const std::string height = fmt::format("{:.2f} m below the median camera", frame.camera_height_m);
  if (frame.IsGiven()) return fmt::format("z = 0 is that of the given trajectory, {}", height);
  if (frame.floor_area_m2 == 0)
    return fmt::format("z = 0 is the {}, {}", frame.floor_source, height);
  return fmt::format("z = 0 is the {}: {:.2f} m2 seen by {} keyframes, {}",
                     frame.floor_source,
                     frame.floor_area_m2,
                     frame.floor_num_keyframes,
                     height);
}

std::string UpWarning(const MapFrame& frame) {
  if (!frame.up_odds || *frame.up_odds >= kSureOfUp) return "";
  return fmt::format(
      "up may be wrong: towards {} it fits what was seen only {:.1f} times as well as towards {}; "
      "state robot_from_camera of the [[camera]] in the site config, or record acceleration",
      frame.up_direction,
      *frame.up_odds,
      frame.next_up_direction);
}

std::vector<std::string> FloorWarnings(const MapFrame& frame) {
  std::vector<std::string> warnings;
  if (frame.IsGiven()) {
    if (frame.camera_height_m > 0) return warnings;
    warnings.emplace_back(
        "the given trajectory does not lie above z = 0: its z must point up and the floor must be "
        "at 0, or set map_frame.source = \"floor\"");
    return warnings;
  }
  if (frame.floor_source != "floor plane") {
    warnings.push_back(fmt::format(
        "no floor was seen: z = 0 is the {}, so heights, grid and paths may be wrong; record the "
        "floor too, or lower map_frame.floor_min_area_m2",
        frame.floor_source));
  }
  if (frame.below_floor_share > kMaxBelowFloorShare) {
    warnings.push_back(fmt::format(
        "{:.0f} % of the measured points lie more than {} m below z = 0: it may be a table or an "
        "upper floor; record more of the floor",
        100 * frame.below_floor_share,
        kBelowFloor_m));
  }
  return warnings;
}

void LogFloor(const MapFrame& frame) {
  spdlog::info("{}", DescribeFloor(frame));
  if (frame.up_odds)
    spdlog::info("up is towards {} ({})", frame.up_direction, frame.gravity_source);
  if (const std::string warning = UpWarning(frame); !warning.empty()) spdlog::warn("{}", warning);
  for (const std::string& warning : FloorWarnings(frame)) spdlog::warn("{}", warning);
}

nlohmann::json Summarize(const MapFrame& frame) {
  const Eigen::Vector3d& t = frame.map_from_given.translation;
  const Eigen::Vector4d& q = frame.map_from_given.rotation.coeffs();
  nlohmann::json report = {{"gravity_source", frame.gravity_source},
                           {"floor", DescribeFloor(frame)},
                           {"floor_warnings", FloorWarnings(frame)},
                           {"floor_source", frame.floor_source},
                           {"floor_area_m2", frame.floor_area_m2},
                           {"floor_num_keyframes", frame.floor_num_keyframes},
                           {"below_floor_percent", 100 * frame.below_floor_share},
                           {"camera_height_m", frame.camera_height_m},
                           {"map_from_given",
                            {{"translation_m", {t.x(), t.y(), t.z()}},
                             {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}}}}};
  if (!frame.up_odds) return report;
  report["up_odds"] = *frame.up_odds;
  report["up_warning"] = UpWarning(frame);
  report["up_direction"] = frame.up_direction;
  report["next_up_direction"] = frame.next_up_direction;
  return report;
}

}  // namespace nightmap
