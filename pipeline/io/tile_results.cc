// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/tile_results.h"

#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/tiles_io.h"

namespace nightmap {

TileResults ReadTileResults(const std::vector<std::filesystem::path>& tiles,
                            const std::vector<std::filesystem::path>& reports,
                            int keyframe_stride) {
  TileResults results;
  std::set<int> keyframes;
  for (const auto& path : tiles) {
    for (const Keyframe& keyframe : ReadTile(path).keyframes) {
      if (keyframe.keyframe_idx % keyframe_stride != 0) continue;
      if (keyframes.empty()) results.first_depth_path = keyframe.frame.depth_path;
      keyframes.insert(keyframe.keyframe_idx);
    }
  }
  std::set<std::string> reasons;
  for (const auto& path : reports) {
    try {
      const auto report = nlohmann::json::parse(ReadFile(path));
      for (const auto& reason : report.value("skipped", nlohmann::json::array())) {
        reasons.insert(reason.get<std::string>());
      }
    } catch (const nlohmann::json::exception& error) {
      throw DataError("{}: {}; delete it and run make", path.string(), error.what());
    }
  }
  results.num_keyframes = keyframes.size();
  results.num_skipped = reasons.size();
  return results;
}

void RemoveOtherTiles(const std::filesystem::path& folder,
                      const std::vector<std::filesystem::path>& tiles) {
  static const std::regex pattern("(?:tile|report|receipt)_(-?[0-9]+_-?[0-9]+)\\.[a-z]+");
  const auto name_of = [](const std::filesystem::path& path) {
    std::smatch match;
    const std::string file = path.filename().string();
    return std::regex_match(file, match, pattern) ? match[1].str() : std::string();
  };
  std::set<std::string> names;
  for (const auto& path : tiles) names.insert(name_of(path));
  std::vector<std::filesystem::path> others;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = name_of(entry.path());
    if (!name.empty() && !names.contains(name)) others.push_back(entry.path());
  }
  for (const auto& path : others) std::filesystem::remove(path);
}

}  // namespace nightmap
