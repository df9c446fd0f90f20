// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/describe_floor.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace nightmap {

std::string DescribeFloor(const MapFrame& frame) {
  const std::string height = fmt::format("{:.2f} m below the median camera", frame.camera_height_m);
  if (frame.floor_area_m2 == 0)
    return fmt::format("z = 0 is the {}, {}", frame.floor_source, height);
  return fmt::format("z = 0 is the {}: {:.2f} m2 seen by {} keyframes, {}",
                     frame.floor_source,
                     frame.floor_area_m2,
                     frame.floor_num_keyframes,
                     height);
}

std::vector<std::string> FloorWarnings(const MapFrame& frame) {
  std::vector<std::string> warnings;
  if (frame.floor_source != "floor plane") {
    warnings.push_back(fmt::format(
        "no floor was seen: z = 0 is the {}, so heights, grid and paths may be wrong; record the "
        "floor too, or lower pose_graph.floor_min_area_m2",
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
  for (const std::string& warning : FloorWarnings(frame)) spdlog::warn("{}", warning);
}

}  // namespace nightmap
