// SPDX-License-Identifier: Apache-2.0
// floors.json: the floors of a map and the files of each, in the same folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/io/grid_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {

struct FloorFiles {
  int number = 0;         // floors above the one at z = 0, the floor of map.yaml; below it negative
  double height_m = 0;    // z of the floor in the map frame
  std::string yaml;       // the grid, for ROS map_server
  std::string png;        // the same for people; empty when there is none
  std::string distances;  // group in distances.h5; empty when there is none
};

// The same floors give the same bytes.
std::string FloorsToJson(const std::vector<FloorFiles>& floors);

// In ascending order of height, number 0 among them. A map's YAML (of another system, say) is one
// floor at z = 0. Throws DataError naming the file when it is missing, not such a file, or a field
// is missing or not of its kind.
std::vector<FloorFiles> ReadFloors(const std::filesystem::path& path);

// The grid of a floor of ReadFloors(the stage's input `port`). Its two files become inputs of the
// stage. Throws DataError as ReadGrid does, and when one is missing.
OccupancyGrid ReadFloorGrid(StageContext& context,
                            const std::string& port,
                            const FloorFiles& floor);

// Place in `floors` of the one of a number.
std::optional<std::size_t> FindFloor(const std::vector<FloorFiles>& floors, int number);

// Place in `floors` of the one that a camera at height `z_m` is above: the highest that is lower;
// the lowest when none is. `floors` must not be empty.
std::size_t FloorBelow(const std::vector<FloorFiles>& floors, double z_m);

// For messages: "floor 1 (z = 2.91 m)", and all of them.
std::string FloorText(const FloorFiles& floor);
std::string FloorsText(const std::vector<FloorFiles>& floors);

}  // namespace nightmap
