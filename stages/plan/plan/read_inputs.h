// SPDX-License-Identifier: Apache-2.0
// Reads what the plan stage plans on.
#pragma once

#include "pipeline/program/stage_context.h"
#include "stages/plan/plan/plan.h"

namespace nightmap {

// Reads the inputs that the run has, and of the floors' grids that of the ends. Throws as their
// readers and PlanFloor do.
PlanInputs ReadPlanInputs(const PlanOptions& options, StageContext& context);

}  // namespace nightmap
