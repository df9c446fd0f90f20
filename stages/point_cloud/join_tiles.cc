// SPDX-License-Identifier: Apache-2.0
#include "stages/point_cloud/join_tiles.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/pcd_io.h"
#include "pipeline/io/tile_results.h"
#include "stages/point_cloud/report_tile.h"

namespace nightmap {
namespace {

using Paths = std::vector<std::filesystem::path>;

std::size_t CountPoints(const Paths& clouds) {
  std::size_t num_points = 0;
  for (const auto& path : clouds) num_points += PlyReader(path).NumPoints();
  return num_points;
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
  const TileResults results =
      CheckTileParts(context, "tile_cloud", options.keyframe_stride, options.max_failed_ratio);
  const std::size_t num_points = CountPoints(clouds);
  if (num_points == 0) {
    throw DataError(
        "{}: no depth within {} m here and in all {} keyframes ({} unreadable), or none that two "
        "pixels agree on; look at the image, check depth_units_per_m of the site's cameras, or "
        "raise point_cloud.max_depth_m",
        results.first_depth_path,
        options.max_depth_m,
        results.num_keyframes,
        results.skipped.Count());
  }
  PlyWriter ply(context.Output("cloud"), num_points);
  JoinClouds(clouds, options.voxel_size_m, [&](const CloudPoint& point) { ply.Add(point); });
  ply.Close();
  ExportPcd(options, context, num_points);
  RemoveOtherTiles(std::filesystem::absolute(context.FinalPath("cloud")).parent_path(), tiles);
  context.Report()["num_tiles"] = tiles.size();
  context.Report()["num_keyframes"] = results.num_keyframes;
  context.Report()["num_points"] = num_points;
  ReportHeldOutRays(context.Inputs("tile_report"), context);
}

}  // namespace nightmap
