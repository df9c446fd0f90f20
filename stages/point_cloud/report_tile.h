// SPDX-License-Identifier: Apache-2.0
// Counts and quality figures of a cloud, for the morning.
#pragma once

#include "pipeline/program/stage_main.h"
#include "stages/point_cloud/point_cloud.h"

namespace nightmap {

// Of one tile. Figures of what was not measured are left out.
void ReportTile(const PointCloudResult& result, StageContext& context);

}  // namespace nightmap
