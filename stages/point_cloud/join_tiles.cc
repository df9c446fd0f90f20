// SPDX-License-Identifier: Apache-2.0
#include "stages/point_cloud/join_tiles.h"

#include <algorithm>
#include <optional>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/pcd_io.h"

namespace nightmap {
namespace {

using Paths = std::vector<std::filesystem::path>;

struct KeyframeSummary {
  std::size_t num_keyframes = 0;  // of all tiles, each counted once
  std::string first_depth_path;
};

KeyframeSummary SummarizeKeyframes(const Paths& tiles, int keyframe_stride) {
  KeyframeSummary summary;
  std::set<int> keyframes;
  for (const auto& path : tiles) {
    for (const Keyframe& keyframe : ReadTile(path).keyframes) {
      if (keyframe.keyframe_idx % keyframe_stride != 0) continue;
      if (keyframes.empty()) summary.first_depth_path = keyframe.frame.depth_path;
      keyframes.insert(keyframe.keyframe_idx);
    }
  }
  summary.num_keyframes = keyframes.size();
  return summary;
}

// A keyframe that cannot be read is skipped by every tile that lists it, for the same reason.
std::size_t CountSkipped(const Paths& reports) {
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
  return reasons.size();
}

std::size_t CountPoints(const Paths& clouds) {
  std::size_t num_points = 0;
  for (const auto& path : clouds) num_points += PlyReader(path).NumPoints();
  return num_points;
}

// By the names of their lists, tile_X_Y.json.
void RemoveVanishedTiles(const Paths& tiles, const std::filesystem::path& folder) {
  constexpr std::size_t kPrefix = 5;
  std::set<std::string> names;
  for (const auto& path : tiles) {
    const std::string stem = path.stem().string();
    if (!stem.starts_with("tile_")) return;
    names.insert(stem.substr(kPrefix));
  }
  RemoveOtherTiles(folder, names);
}

// An export that is not asked for any more would be of another cloud.
void ExportPcd(const PointCloudOptions& options, StageContext& context, std::size_t num_points) {
  constexpr const char* kName = "cloud.pcd";
  if (!options.export_pcd) {
    std::filesystem::remove(context.FinalPath("cloud").replace_filename(kName));
    return;
  }
  PcdWriter pcd(context.OutputBeside("cloud", kName), num_points);
  JoinClouds(context.Inputs("tile_cloud"), options.voxel_size_m, [&](const CloudPoint& point) {
    pcd.Add(point);
  });
  pcd.Close();
}

}  // namespace

void JoinClouds(const std::vector<std::filesystem::path>& clouds,
                double voxel_size_m,
                const std::function<void(const CloudPoint&)>& add) {
  struct Head {
    CloudPoint point;
    std::size_t cloud;
  };
  const auto later = [voxel_size_m](const Head& a, const Head& b) {
    return ByVoxel(b.point, a.point, voxel_size_m);
  };
  std::vector<PlyReader> readers;
  std::vector<Head> heads;  // a heap with the first point in front
  const auto advance = [&](std::size_t cloud) {
    const auto point = readers[cloud].Next();
    if (!point) return;
    heads.push_back({*point, cloud});
    std::ranges::push_heap(heads, later);
  };
  for (const auto& path : clouds) readers.emplace_back(path);
  for (std::size_t cloud = 0; cloud < readers.size(); ++cloud) advance(cloud);
  while (!heads.empty()) {
    std::ranges::pop_heap(heads, later);
    const Head head = heads.back();
    heads.pop_back();
    add(head.point);
    advance(head.cloud);
  }
}

void JoinTiles(const PointCloudOptions& options, StageContext& context) {
  const Paths& tiles = context.Inputs("tile");
  const Paths& clouds = context.Inputs("tile_cloud");
  const Paths& reports = context.Inputs("tile_report");
  if (clouds.size() != tiles.size() || reports.size() != tiles.size()) {
    throw UsageError("--out cloud needs as many tile_cloud and tile_report as tile: {}, {} and {}",
                     clouds.size(),
                     reports.size(),
                     tiles.size());
  }
  const KeyframeSummary summary = SummarizeKeyframes(tiles, options.keyframe_stride);
  const std::size_t num_skipped = CountSkipped(reports);
  CheckFailedRatio(num_skipped, summary.num_keyframes, options.max_failed_ratio);
  const std::size_t num_points = CountPoints(clouds);
  if (num_points == 0) {
    throw DataError(
        "{}: no depth within {} m here and in all {} keyframes ({} unreadable), or none that two "
        "pixels agree on; look at the image, check depth_units_per_m of the site's cameras, or "
        "raise point_cloud.max_depth_m",
        summary.first_depth_path,
        options.max_depth_m,
        summary.num_keyframes,
        num_skipped);
  }
  PlyWriter ply(context.Output("cloud"), num_points);
  JoinClouds(clouds, options.voxel_size_m, [&](const CloudPoint& point) { ply.Add(point); });
  ply.Close();
  ExportPcd(options, context, num_points);
  RemoveVanishedTiles(tiles, std::filesystem::absolute(context.FinalPath("cloud")).parent_path());
  context.Report()["num_tiles"] = tiles.size();
  context.Report()["num_keyframes"] = summary.num_keyframes;
  context.Report()["num_points"] = num_points;
}

}  // namespace nightmap
