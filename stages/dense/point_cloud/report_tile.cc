// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/report_tile.h"

#include <string>

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

}  // namespace nightmap
