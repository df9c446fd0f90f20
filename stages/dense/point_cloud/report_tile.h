// SPDX-License-Identifier: Apache-2.0
// Counts and quality figures of a cloud for the report.
#pragma once

#include "pipeline/program/stage_main.h"
#include "stages/dense/point_cloud/point_cloud.h"

namespace nightmap {

// Reports one tile. Leaves out figures that were not measured.
void ReportTile(const PointCloudResult& result, StageContext& context);

}  // namespace nightmap
