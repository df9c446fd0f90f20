// SPDX-License-Identifier: Apache-2.0
#include "stages/point_cloud/report_tile.h"

#include <string>

#include "pipeline/io/tile_results.h"

namespace nightmap {

void ReportTile(const PointCloudResult& result, StageContext& context) {
  for (const std::string& reason : result.skipped) context.Skip(reason);
  auto& report = context.Report();
  report["num_measurements"] = result.num_measurements;
  report["num_voxels"] = result.num_voxels;
  report["num_inconsistent"] = result.num_inconsistent;
  report["num_outliers"] = result.num_outliers;
  report["num_held_out_rays"] = result.held_out.num_rays;
  report["num_held_out_rays_agreeing"] = result.held_out.num_agreeing;
  report["num_held_out_rays_blocked"] = result.held_out.num_blocked;
  if (result.plane_thickness_p90_m > 0) {
    report["plane_thickness_median_m"] = result.plane_thickness_median_m;
    report["plane_thickness_p90_m"] = result.plane_thickness_p90_m;
  }
}

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

}  // namespace nightmap
