// SPDX-License-Identifier: Apache-2.0
#include "stages/tiles/write_tiles.h"

#include <vector>

#include "pipeline/base/files.h"
#include "pipeline/io/tile_results.h"

namespace nightmap {
namespace {

constexpr const char* kPort = "tiles_mk";

std::string ListName(const TileIndex& index) { return "tile_" + TileName(index) + ".json"; }

std::string TilesMk(const std::map<TileIndex, Tile>& tiles) {
  std::string all = "TILES :=", near;
  for (const auto& [index, tile] : tiles) {
    all += " " + TileName(index);
    near += "NEAR_" + TileName(index) + " :=";
    for (int i = 0; i < 9; ++i) {
      const TileIndex other{index.first + i / 3 - 1, index.second + i % 3 - 1};
      if (tiles.contains(other)) near += " " + TileName(other);
    }
    near += "\n";
  }
  return all + "\n" + near;
}

}  // namespace

void WriteTiles(const std::vector<RgbdCamera>& cameras,
                const std::map<TileIndex, Tile>& tiles,
                StageContext& context) {
  std::vector<std::filesystem::path> lists;
  WriteFile(context.OutputBeside(kPort, "cameras.json"), CamerasToJson(cameras));
  for (const auto& [index, tile] : tiles) {
    lists.emplace_back(ListName(index));
    WriteFile(context.OutputBeside(kPort, lists.back()), TileToJson(tile));
  }
  WriteFile(context.Output(kPort), TilesMk(tiles));
  RemoveOtherTiles(std::filesystem::absolute(context.FinalPath(kPort)).parent_path(), lists);
}

}  // namespace nightmap
