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
  // Number of floors above the one at z = 0 (the floor of map.yaml); negative below it.
  int number = 0;
  double height_m = 0;    // z of the floor in the map frame
  std::string yaml;       // the grid, for ROS map_server
  std::string png;        // the grid as a picture; empty when there is none
  std::string distances;  // group in distances.h5; empty when there is none
};

// The same floors give the same bytes.
std::string FloorsToJson(const std::vector<FloorFiles>& floors);

// Writes a grid as the only floor, at z = 0: the stage's outputs `pgm`, `yaml`, `png` and `floors`,
// which lie in one folder.
void WriteOneFloor(const OccupancyGrid& grid, StageContext& context);

// Floors in ascending order of height; number 0 is among them. Accepts a map's YAML (of another
// system, say) as one floor at z = 0. Throws DataError naming the file when it is missing or of
// another format, or a field is missing or of the wrong type.
std::vector<FloorFiles> ReadFloors(const std::filesystem::path& path);

// Reads the grid of a floor of ReadFloors(the stage's input `port`). Its two files become inputs of
// the stage. Throws DataError as ReadGrid does, and when one is missing.
OccupancyGrid ReadFloorGrid(StageContext& context,
                            const std::string& port,
                            const FloorFiles& floor);

// Index in `floors` of the floor with this number.
std::optional<std::size_t> FindFloor(const std::vector<FloorFiles>& floors, int number);

// Index in `floors` of the floor below a camera at height `z_m`: the highest that is lower than the
// camera, or the lowest when none is. `floors` must not be empty.
std::size_t FloorBelow(const std::vector<FloorFiles>& floors, double z_m);

// For messages: "floor 1 (z = 2.91 m)", and a list of all floors.
std::string FloorText(const FloorFiles& floor);
std::string FloorsText(const std::vector<FloorFiles>& floors);
// "0.000,0.000 to 6.000,4.000": least and greatest x and y of the grid's corners; a grid with a yaw
// is turned within them.
std::string SpanText(const OccupancyGrid& grid);

}  // namespace nightmap
