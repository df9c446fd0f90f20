// SPDX-License-Identifier: Apache-2.0
// Outputs of the odometry stage.
#pragma once

#include "pipeline/program/stage_main.h"
#include "stages/camera/odometry/odometry.h"

namespace nightmap {

// Writes the shard and, where it is wanted, its trajectory, and fills the report.
void WriteOdometryResult(const OdometryInput& input,
                         const OdometryResult& result,
                         StageContext& context);

}  // namespace nightmap
