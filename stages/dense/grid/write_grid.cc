// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/write_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <string_view>

#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/image_io.h"
#include "pipeline/plan/floors_io.h"
#include "stages/dense/grid/distance_maps.h"

namespace nightmap {
namespace {

constexpr const char* kUnits =
    "m; map frame; clearance_m: centre of a free cell to the centre of the nearest that is not "
    "free, 0 elsewhere; signed_distance_m: centre to centre, to the nearest occupied cell, and "
    "negative in occupied cells, to the nearest other; row 0 has the smallest y; "
    "origin_in_map_m: lower left corner";

int FloorNumber(const GridResult& result, std::size_t floor_idx) {
  return static_cast<int>(floor_idx) - static_cast<int>(result.main_floor_idx);
}

// File stem of a floor, and its group in distances.h5.
std::string FloorName(const GridResult& result, std::size_t floor_idx) {
  return fmt::format("floor_{}", FloorNumber(result, floor_idx));
}

void WriteDistances(const GridResult& result, StageContext& context) {
  Hdf5Writer file(
      context.Output("distances"), "nightmap grid distances", 1, context.ConfigToml(), kUnits);
  for (std::size_t i = 0; i < result.floors.size(); ++i) {
    const OccupancyGrid& grid = result.floors[i].grid;
    const std::string group = FloorName(result, i) + "/";
    const auto write = [&](const char* name, std::vector<float> values) {
      file.Write(group + name,
                 Array<float>{static_cast<std::size_t>(grid.height),
                              static_cast<std::size_t>(grid.width),
                              std::move(values)});
    };
    write("clearance_m", Clearance_m(grid, context.NumThreads()));
    write("signed_distance_m", SignedDistance_m(grid, context.NumThreads()));
    file.WriteList<double>(group + "origin_in_map_m",
                           {grid.origin_in_map.x(), grid.origin_in_map.y()});
    file.WriteList<double>(group + "resolution_m", {grid.resolution_m});
    file.WriteList<double>(group + "height_m", {result.floors[i].height_m});
  }
  file.Close();
}

// Writes the files whose number depends on the map, next to floors.json.
class OutputFiles {
 public:
  explicit OutputFiles(StageContext& context) : context_(context) {}

  std::filesystem::path Path(const std::string& name) {
    names_.insert(name);
    return context_.OutputBeside("floors", name);
  }

  void RemoveOthers() const {
    const auto folder = std::filesystem::absolute(context_.FinalPath("floors")).parent_path();
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (IsOurs(name) && entry.is_regular_file() && !names_.contains(name)) {
        std::filesystem::remove(entry.path());
      }
    }
  }

 private:
  // Whether a name is floor_N.pgm, .yaml or .png with a number N; the user may keep other files
  // there.
  static bool IsOurs(std::string_view name) {
    constexpr std::string_view kStart = "floor_";
    const std::size_t dot = std::min(name.find('.'), name.size());
    const std::string_view suffix = name.substr(dot);
    return name.starts_with(kStart) &&
           (suffix == ".pgm" || suffix == ".yaml" || suffix == ".png") &&
           ParseInteger(name.substr(kStart.size(), dot - kStart.size())).has_value();
  }

  StageContext& context_;
  std::set<std::string> names_;
};

void WritePair(const OccupancyGrid& grid,
               const std::filesystem::path& pgm,
               const std::filesystem::path& yaml,
               const std::string& image_name) {
  WriteFile(pgm, GridToPgm(grid));
  WriteFile(yaml, GridToYaml(grid, image_name));
}

nlohmann::json DescribeFloor(const FloorGrid& floor) {
  const double cell_m2 = floor.grid.resolution_m * floor.grid.resolution_m;
  const std::size_t num_seen_cells = floor.num_free_cells + floor.num_occupied_cells;
  return {{"height_m", floor.height_m},
          {"width_cells", floor.grid.width},
          {"height_cells", floor.grid.height},
          {"resolution_m", floor.grid.resolution_m},
          {"num_free_cells", floor.num_free_cells},
          {"num_occupied_cells", floor.num_occupied_cells},
          {"num_unknown_cells", floor.num_unknown_cells},
          {"num_ground_cells", floor.num_ground_cells},
          {"num_ramp_cells", floor.num_ramp_cells},
          {"num_drop_cells", floor.num_drop_cells},
          {"num_unvisited_cells", floor.num_unvisited_cells},
          {"num_removed_specks", floor.num_removed_specks},
          {"free_area_m2", cell_m2 * static_cast<double>(floor.num_free_cells)},
          {"seen_area_m2", cell_m2 * static_cast<double>(num_seen_cells)}};
}

}  // namespace

void WriteGrids(const GridResult& result, StageContext& context) {
  const auto name_of = [&](const char* port) {
    return context.FinalPath(port)
        .lexically_proximate(context.FinalPath("yaml").parent_path())
        .generic_string();
  };
  const bool has_png = context.HasOutput("png"), has_distances = context.HasOutput("distances");
  OutputFiles files(context);
  std::vector<FloorFiles> list;
  for (std::size_t i = 0; i < result.floors.size(); ++i) {
    const FloorGrid& floor = result.floors[i];
    const bool is_main = i == result.main_floor_idx;
    const std::string stem = is_main ? "map" : FloorName(result, i);
    if (is_main) {
      WritePair(floor.grid, context.Output("pgm"), context.Output("yaml"), name_of("pgm"));
      if (has_png) WritePng(context.Output("png"), GridToImage(floor.grid));
    } else {
      WritePair(floor.grid, files.Path(stem + ".pgm"), files.Path(stem + ".yaml"), stem + ".pgm");
      if (has_png) WritePng(files.Path(stem + ".png"), GridToImage(floor.grid));
    }
    list.push_back({.number = FloorNumber(result, i),
                    .height_m = floor.height_m,
                    .yaml = is_main ? name_of("yaml") : stem + ".yaml",
                    .png = !has_png  ? ""
                           : is_main ? name_of("png")
                                     : stem + ".png",
                    .distances = has_distances ? FloorName(result, i) : ""});
  }
  if (has_distances) WriteDistances(result, context);
  WriteFile(context.Output("floors"), FloorsToJson(list));
  files.RemoveOthers();
}

nlohmann::json DescribeGrids(const GridResult& result) {
  nlohmann::json floors = nlohmann::json::array();
  for (const FloorGrid& floor : result.floors) floors.push_back(DescribeFloor(floor));
  nlohmann::json report = floors[result.main_floor_idx];
  report["below_lowest_floor_percent"] = 100 * result.below_lowest_share;
  report["num_floors"] = result.floors.size();
  report["floors"] = floors;
  return report;
}

}  // namespace nightmap
