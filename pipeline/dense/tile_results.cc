// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/tile_results.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/dense/tiles_io.h"
#include "pipeline/io/json_fields.h"

namespace nightmap {
namespace {

constexpr std::array<std::string_view, 4> kKinds = {"tile", "places", "report", "receipt"};

// X_Y of <one of kKinds>_X_Y.*; empty for any other file.
std::string TileNameOf(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  const std::size_t end = stem.find('_');
  if (end == std::string::npos) return {};
  const std::string kind = stem.substr(0, end);
  if (std::ranges::count(kKinds, kind) == 0) return {};
  const std::string name = stem.substr(end + 1);
  const bool is_numbers = name.find_first_not_of("-0123456789_") == std::string::npos;
  return is_numbers && std::ranges::count(name, '_') == 1 ? name : std::string();
}

// Calls use(report) with the file's content; a value missing there is an error of the file.
template <typename Use>
void ReadReport(const std::filesystem::path& path, const Use& use) {
  try {
    use(nlohmann::json::parse(ReadFile(path)));
  } catch (const nlohmann::json::exception& error) {
    throw DataError("{}: {}; delete it and run make", path.string(), JsonReason(error));
  }
}

}  // namespace

TileResults ReadTileResults(const std::vector<std::filesystem::path>& tiles,
                            const std::vector<std::filesystem::path>& reports) {
  TileResults results{TileConfig(reports), 0, {}, {}};
  const int keyframe_stride = results.config.Integer("keyframe_stride", Range(1, 1000));
  std::set<int> keyframes;
  for (const auto& path : tiles) {
    for (const Keyframe& keyframe : ReadTile(path).keyframes) {
      if (keyframe.keyframe_idx % keyframe_stride != 0) continue;
      if (keyframes.empty()) results.first_depth_path = keyframe.frame.depth.path;
      keyframes.insert(keyframe.keyframe_idx);
    }
  }
  std::set<std::string> reasons;
  for (const auto& path : reports) {
    ReadReport(path, [&](const nlohmann::json& report) {
      const auto skipped = report.find("skipped");
      if (skipped == report.end()) return;
      for (const auto& reason : *skipped) reasons.insert(reason.get<std::string>());
    });
  }
  results.num_keyframes = keyframes.size();
  for (const std::string& reason : reasons) results.skipped.Add(reason);
  return results;
}

TileResults CheckTileParts(const StageContext& context,
                           const std::string& part,
                           double max_failed_ratio) {
  const auto& tiles = context.Inputs("tile");
  const auto& reports = context.Inputs("tile_report");
  const std::size_t num_parts = context.Inputs(part).size();
  if (num_parts != tiles.size() || reports.size() != tiles.size()) {
    throw UsageError("to join tiles give as many {} and tile_report as tile: {}, {} and {}",
                     part,
                     num_parts,
                     reports.size(),
                     tiles.size());
  }
  const TileResults results = ReadTileResults(tiles, reports);
  results.skipped.Check(results.num_keyframes, max_failed_ratio);
  return results;
}

std::size_t SumOfReports(const std::vector<std::filesystem::path>& reports,
                         const std::string& count) {
  std::size_t sum = 0;
  for (const auto& path : reports) {
    ReadReport(path, [&](const nlohmann::json& report) {
      const auto& value = report.at(count);
      if (!value.is_number_unsigned()) {
        throw DataError("{}: {} is no count; delete it and run make", path.string(), count);
      }
      sum += value.get<std::size_t>();
    });
  }
  return sum;
}

void RemoveOtherTiles(const std::filesystem::path& folder,
                      const std::vector<std::filesystem::path>& tiles) {
  std::set<std::string> names;
  for (const auto& path : tiles) names.insert(TileNameOf(path));
  std::vector<std::filesystem::path> others;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = TileNameOf(entry.path());
    if (!name.empty() && !names.contains(name)) others.push_back(entry.path());
  }
  for (const auto& path : others) std::filesystem::remove(path);
}

}  // namespace nightmap
