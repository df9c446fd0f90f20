// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/floors_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/json_fields.h"

namespace nightmap {
namespace {

using FloorJson = nlohmann::ordered_json;

constexpr const char* kFloorsFormat = "nightmap floors";
constexpr int kFloorsVersion = 2;
constexpr int kMaxNumber = 1000;  // largest number of a floor

FloorFiles FloorFromJson(const FloorJson& json) {
  FloorFiles floor{IntegerAt(json, "number", -kMaxNumber, kMaxNumber),
                   FiniteAt(json, "height_m"),
                   json.at("yaml").get<std::string>(),
                   json.at("png").get<std::string>(),
                   json.at("distances").get<std::string>()};
  if (floor.yaml.empty()) throw DataError("floor {} has no yaml", floor.number);
  return floor;
}

void CheckFloors(const std::vector<FloorFiles>& floors) {
  if (!FindFloor(floors, 0)) throw DataError("there is no floor of number 0");
  for (std::size_t i = 1; i < floors.size(); ++i) {
    if (floors[i].number != floors[i - 1].number + 1) throw DataError("numbers must ascend by 1");
    if (floors[i].height_m <= floors[i - 1].height_m) {
      throw DataError("floors must ascend in height_m");
    }
  }
}

std::vector<FloorFiles> FloorsFromJson(const FloorJson& json) {
  if (json.at("format").get<std::string>() != kFloorsFormat) {
    throw DataError("format is not '{}'", kFloorsFormat);
  }
  const int version = IntegerAt(json, "version");
  if (version != kFloorsVersion) {
    throw DataError("version {}, this program reads {}", version, kFloorsVersion);
  }
  std::vector<FloorFiles> floors;
  for (const FloorJson& floor : json.at("floors")) floors.push_back(FloorFromJson(floor));
  CheckFloors(floors);
  return floors;
}

}  // namespace

std::string FloorsToJson(const std::vector<FloorFiles>& floors) {
  FloorJson list = FloorJson::array();
  for (const FloorFiles& floor : floors) {
    list.push_back({{"number", floor.number},
                    {"height_m", floor.height_m},
                    {"yaml", floor.yaml},
                    {"png", floor.png},
                    {"distances", floor.distances}});
  }
  const FloorJson json = {{"format", kFloorsFormat},
                          {"version", kFloorsVersion},
                          {"units", "height_m: z of the floor in the map frame"},
                          {"floors", list}};
  return json.dump(2) + "\n";
}

void WriteOneFloor(const OccupancyGrid& grid, StageContext& context) {
  const auto name = [&](const char* port) { return context.FinalPath(port).filename().string(); };
  FloorFiles floor;
  floor.yaml = name("yaml");
  floor.png = name("png");
  WriteFile(context.Output("pgm"), GridToPgm(grid));
  WriteFile(context.Output("yaml"), GridToYaml(grid, name("pgm")));
  WritePng(context.Output("png"), GridToImage(grid));
  WriteFile(context.Output("floors"), FloorsToJson({floor}));
}

std::vector<FloorFiles> ReadFloors(const std::filesystem::path& path) {
  if (path.extension() == ".yaml" || path.extension() == ".yml") {
    return {{.yaml = path.filename().string(), .png = {}, .distances = {}}};
  }
  const std::string text = ReadFile(path);
  try {
    return FloorsFromJson(FloorJson::parse(text));
  } catch (const std::exception& error) {
    throw DataError("{}: {}; delete the grid folder of this site and run make map",
                    path.string(),
                    JsonReason(error));
  }
}

OccupancyGrid ReadFloorGrid(StageContext& context,
                            const std::string& port,
                            const FloorFiles& floor) {
  const std::filesystem::path list = context.Input(port);
  const std::filesystem::path yaml = list.parent_path() / floor.yaml;
  context.AddInput(yaml, list);
  context.AddInput(GridImagePath(yaml), yaml);
  return ReadGrid(yaml);
}

std::optional<std::size_t> FindFloor(const std::vector<FloorFiles>& floors, int number) {
  const auto found = std::ranges::find(floors, number, &FloorFiles::number);
  if (found == floors.end()) return {};
  return static_cast<std::size_t>(found - floors.begin());
}

std::size_t FloorBelow(const std::vector<FloorFiles>& floors, double z_m) {
  const auto above = std::ranges::lower_bound(floors, z_m, {}, &FloorFiles::height_m);
  return above == floors.begin() ? 0 : static_cast<std::size_t>(above - floors.begin()) - 1;
}

std::string FloorText(const FloorFiles& floor) {
  return fmt::format("floor {} (z = {:.2f} m)", floor.number, floor.height_m);
}

std::string FloorsText(const std::vector<FloorFiles>& floors) {
  std::string text;
  for (const FloorFiles& floor : floors) text += (text.empty() ? "" : ", ") + FloorText(floor);
  return text;
}

std::string SpanText(const OccupancyGrid& grid) {
  Eigen::AlignedBox2d box;
  for (const int x : {0, grid.width}) {
    for (const int y : {0, grid.height}) box.extend(grid.FromCells(Eigen::Vector2d(x, y)));
  }
  return fmt::format(
      "{:.3f},{:.3f} to {:.3f},{:.3f}", box.min().x(), box.min().y(), box.max().x(), box.max().y());
}

}  // namespace nightmap
