// SPDX-License-Identifier: Apache-2.0
// things.json: things with names that stand in the map, each as an upright box. One thing per
// line.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid2.h"

namespace nightmap {

// The picture that shows a thing best, and where in it the thing is.
struct ThingView {
  std::int64_t time_ns = 0;
  std::string color_path;  // relative to the data root
  // In pixels: left, top, and behind the last column and row.
  std::array<int, 4> rectangle_px{};
};

struct Thing {
  std::string name;        // class and number, "sofa_2"; unique in its file
  std::string class_name;  // "sofa"
  Rigid2 map_from_thing;   // the origin is the footprint's centre; x points out of the front
  double bottom_m = 0;     // z of the box's lower face in the map frame
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // along x, y of the thing's frame, and z
  int num_views = 0;                                 // keyframes that see it
  double confidence = 0;                             // of its class, 0 .. 1
  std::optional<ThingView> best_view = {};
};

// Equal things give equal bytes, and numbers are read back exactly.
std::string ThingsToJson(const std::vector<Thing>& things);

// Throws DataError naming file and thing on another format, a newer version, a missing key, a
// number that is not finite or out of range, an empty or repeated name.
std::vector<Thing> ReadThings(const std::filesystem::path& path);

}  // namespace nightmap
