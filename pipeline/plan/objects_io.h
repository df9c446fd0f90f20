// SPDX-License-Identifier: Apache-2.0
// objects.yaml: object features, which are rectangles on unchanging places of a laser map that a
// robot is located by (publication CN110307838A). The objects stage proposes them; people edit
// them.
//
//   format: nightmap objects
//   version: 1
//   objects:
//     - name: "column 1"
//       x_m: 1.25              # centre in the map frame
//       y_m: 3.4
//       size_x_m: 0.8          # along the rectangle's own axes
//       size_y_m: 0.6
//       angle_deg: 30          # of its x axis, counter-clockwise from the map's x
//       distinctiveness: 0.83  # 0 .. 1, may be missing
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid2.h"

namespace nightmap {

struct MapObject {
  std::string name;        // UTF-8, not empty, unique in its file
  Rigid2 map_from_object;  // the origin of the object's frame is the rectangle's centre
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();  // along the axes of the object's frame
  std::optional<double> distinctiveness;  // how badly the place fits anywhere else, 0 .. 1
};

// Equal objects give equal bytes. Reading gives the same metres, and headings within 1e-9 degrees;
// writing these again gives the same bytes. Throws DataError when a name is not UTF-8.
std::string ObjectsToYaml(const std::vector<MapObject>& objects);

// Reads any YAML 1.2 that holds the keys above. Throws DataError naming file and line on an
// unknown, missing or repeated key, a number that is not finite or not in its range, an empty or
// repeated name, another format or a newer version.
std::vector<MapObject> ReadObjects(const std::filesystem::path& path);

// Cuts sides longer than max_size_m to it, about the object's centre. Returns a notice per object
// that was cut, with its name and both sizes.
std::vector<std::string> ClampObjects(double max_size_m, std::vector<MapObject>* objects);

// Whether a point lies in the rectangle or on its border.
bool Contains(const MapObject& object, const Eigen::Vector2d& point_in_map);

}  // namespace nightmap
