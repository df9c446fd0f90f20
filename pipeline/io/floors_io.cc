// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/floors_io.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

namespace nightmap {
namespace {

using FloorJson = nlohmann::ordered_json;

constexpr const char* kFloorsFormat = "nightmap floors";
constexpr int kFloorsVersion = 1;

FloorFiles FloorFromJson(const FloorJson& json) {
  FloorFiles floor{json.at("height_m").get<double>(),
                   json.at("is_main").get<bool>(),
                   json.at("yaml").get<std::string>(),
                   json.at("png").get<std::string>(),
                   json.at("distances").get<std::string>()};
  if (!std::isfinite(floor.height_m)) throw DataError("height_m is not finite");
  return floor;
}

std::vector<FloorFiles> FloorsFromJson(const FloorJson& json) {
  if (json.at("format").get<std::string>() != kFloorsFormat) {
    throw DataError("format is not '{}'", kFloorsFormat);
  }
  if (json.at("version").get<int>() > kFloorsVersion) {
    throw DataError("version is newer than {}: update nightmap", kFloorsVersion);
  }
  std::vector<FloorFiles> floors;
  for (const FloorJson& floor : json.at("floors")) floors.push_back(FloorFromJson(floor));
  if (std::ranges::count_if(floors, &FloorFiles::is_main) != 1) {
    throw DataError("of the floors not exactly one is the main floor");
  }
  if (!std::ranges::is_sorted(floors, {}, &FloorFiles::height_m)) {
    throw DataError("floors must ascend in height_m");
  }
  return floors;
}

}  // namespace

std::string FloorsToJson(const std::vector<FloorFiles>& floors) {
  FloorJson list = FloorJson::array();
  for (std::size_t i = 0; i < floors.size(); ++i) {
    list.push_back({{"idx", i},
                    {"height_m", floors[i].height_m},
                    {"is_main", floors[i].is_main},
                    {"yaml", floors[i].yaml},
                    {"png", floors[i].png},
                    {"distances", floors[i].distances}});
  }
  const FloorJson json = {{"format", kFloorsFormat},
                          {"version", kFloorsVersion},
                          {"units", "height_m: z of the floor in the map frame"},
                          {"floors", list}};
  return json.dump(2) + "\n";
}

std::vector<FloorFiles> ReadFloors(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  try {
    return FloorsFromJson(FloorJson::parse(text));
  } catch (const std::exception& error) {
    throw DataError("{}: {}; delete the grid folder of this site and run make map",
                    path.string(),
                    error.what());
  }
}

std::size_t FloorBelow(const std::vector<FloorFiles>& floors, double z_m) {
  const auto above = std::ranges::lower_bound(floors, z_m, {}, &FloorFiles::height_m);
  return above == floors.begin() ? 0 : static_cast<std::size_t>(above - floors.begin()) - 1;
}

}  // namespace nightmap
