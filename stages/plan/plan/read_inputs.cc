// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/read_inputs.h"

#include "pipeline/io/things_io.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {

PlanInputs ReadPlanInputs(const PlanOptions& options, StageContext& context) {
  PlanInputs inputs;
  inputs.floors = ReadFloors(context.Input("grid"));
  if (context.HasInput("queries")) inputs.queries = ReadQueries(context.Input("queries"));
  if (context.HasInput("trajectory")) inputs.trajectory = ReadTum(context.Input("trajectory"));
  if (context.HasInput("objects")) inputs.objects = ReadObjects(context.Input("objects"));
  if (context.HasInput("things")) inputs.things = ReadThings(context.Input("things"));
  inputs.floor_idx = PlanFloor(options, inputs);
  inputs.grid = ReadFloorGrid(context, "grid", inputs.floors[inputs.floor_idx]);
  return inputs;
}

}  // namespace nightmap
