// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_clouds/write_joined_cloud.h"

#include <memory>

#include "pipeline/base/error.h"
#include "pipeline/dense/tile_results.h"
#include "stages/dense/join_clouds/pcd_io.h"

namespace nightmap {
namespace {

using Paths = std::vector<std::filesystem::path>;

std::size_t CountPoints(const Paths& clouds) {
  std::size_t num_points = 0;
  for (const auto& path : clouds) num_points += PlyReader(path).NumPoints();
  return num_points;
}

void Join(const Paths& clouds,
          double voxel_size_m,
          const std::function<void(const CloudPoint&)>& add) {
  std::vector<PointSource> sources;
  for (const auto& path : clouds) {
    const auto reader = std::make_shared<PlyReader>(path);
    sources.emplace_back([reader] { return reader->Next(); });
  }
  RunJoinClouds(sources, voxel_size_m, add);
}

// Removes an export that is no longer asked for, because it would show another cloud.
void ExportPcd(bool is_wanted, double voxel_size_m, std::size_t num_points, StageContext& context) {
  constexpr const char* kName = "cloud.pcd";
  if (!is_wanted) {
    std::filesystem::remove(context.FinalPath("cloud").replace_filename(kName));
    return;
  }
  PcdWriter pcd(context.OutputBeside("cloud", kName), num_points);
  Join(
      context.Inputs("tile_cloud"), voxel_size_m, [&](const CloudPoint& point) { pcd.Add(point); });
  pcd.Close();
}

void CheckAnyPoint(std::size_t num_points, const TileResults& results) {
  if (num_points > 0) return;
  throw DataError(
      "{}: no depth within {} m here and in all {} keyframes ({} unreadable), or none that two "
      "pixels agree on; look at the image, check depth_units_per_m of the site's cameras, or "
      "raise point_cloud.max_depth_m",
      results.first_depth_path,
      results.config.Number("max_depth_m", Range(0.0, 1e6)),
      results.num_keyframes,
      results.skipped.Count());
}

// Shares of the held-out rays over all tiles, from the counts in their reports. Throws DataError
// naming a report without them.
void ReportHeldOutRays(const std::vector<std::filesystem::path>& tile_reports,
                       StageContext& context) {
  const std::size_t num_rays = SumOfReports(tile_reports, "num_held_out_rays");
  const auto report = [&](const char* name, const char* count) {
    const auto num_such = static_cast<double>(SumOfReports(tile_reports, count));
    if (num_rays > 0) context.Report()[name] = 100 * num_such / static_cast<double>(num_rays);
  };
  report("held_out_rays_agreeing_percent", "num_held_out_rays_agreeing");
  report("held_out_rays_blocked_percent", "num_held_out_rays_blocked");
}

}  // namespace

void WriteJoinedCloud(const JoinCloudsOptions& options, StageContext& context) {
  const Paths& tiles = context.Inputs("tile");
  const Paths& clouds = context.Inputs("tile_cloud");
  const TileResults results = CheckTileParts(context, "tile_cloud", options.max_failed_ratio);
  const double voxel_size_m = results.config.Number("voxel_size_m", Range(1e-6, 1e6));
  const std::size_t num_points = CountPoints(clouds);
  CheckAnyPoint(num_points, results);
  PlyWriter ply(context.Output("cloud"), num_points);
  Join(clouds, voxel_size_m, [&](const CloudPoint& point) { ply.Add(point); });
  ply.Close();
  ExportPcd(options.export_pcd, voxel_size_m, num_points, context);
  RemoveOtherTiles(std::filesystem::absolute(context.FinalPath("cloud")).parent_path(), tiles);
  context.Report()["num_tiles"] = tiles.size();
  context.Report()["num_keyframes"] = results.num_keyframes;
  context.Report()["num_points"] = num_points;
  ReportHeldOutRays(context.Inputs("tile_report"), context);
}

}  // namespace nightmap
