// SPDX-License-Identifier: Apache-2.0
// floors.json: the floors of a map and the files of each, in the same folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace nightmap {

struct FloorFiles {
  double height_m = 0;    // z of the floor in the map frame
  bool is_main = false;   // exactly one is: the floor of map.yaml
  std::string yaml;       // the grid, for ROS map_server
  std::string png;        // the same for people
  std::string distances;  // group in distances.h5
};

// The same floors give the same bytes.
std::string FloorsToJson(const std::vector<FloorFiles>& floors);

// In ascending order of height, at least one. Throws DataError naming the file when it is missing,
// not such a file, or a field is missing or not of its kind.
std::vector<FloorFiles> ReadFloors(const std::filesystem::path& path);

// Place in `floors` of the one that a camera at height `z_m` is above: the highest that is lower;
// the lowest when none is. `floors` must not be empty.
std::size_t FloorBelow(const std::vector<FloorFiles>& floors, double z_m);

}  // namespace nightmap
