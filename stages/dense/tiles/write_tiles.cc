// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/tiles/write_tiles.h"

#include <string>
#include <vector>

#include "pipeline/base/files.h"
#include "pipeline/dense/tile_results.h"
#include "pipeline/io/unit_list.h"

namespace nightmap {
namespace {

constexpr const char* kPort = "tiles";

std::string ListName(const TileIndex& index) { return "tile_" + TileName(index) + ".json"; }

}  // namespace

void WriteTiles(const std::vector<RgbdCamera>& cameras,
                const std::map<TileIndex, Tile>& tiles,
                StageContext& context) {
  std::vector<std::filesystem::path> lists;
  std::vector<std::string> names;
  WriteFile(context.OutputBeside(kPort, "cameras.json"), CamerasToJson(cameras));
  for (const auto& [index, tile] : tiles) {
    names.push_back(TileName(index));
    lists.emplace_back(ListName(index));
    WriteFile(context.OutputBeside(kPort, lists.back()), TileToJson(tile));
  }
  WriteFile(context.Output(kPort), NameListToText("tiles", names));
  RemoveOtherTiles(std::filesystem::absolute(context.FinalPath(kPort)).parent_path(), lists);
}

}  // namespace nightmap
