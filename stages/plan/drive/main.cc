// SPDX-License-Identifier: Apache-2.0
// drive: a simulated differential-drive robot follows the planned path. Reads path.csv and
// path.json, and floors.json with the grid of the path's floor; writes drive.csv, drive.json and
// drive.gif.
#include "pipeline/base/files.h"
#include "pipeline/plan/floors_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/plan/drive/drive.h"
#include "stages/plan/drive/drive_output.h"
#include "stages/plan/drive/gif_io.h"

namespace {

using namespace nightmap;

OccupancyGrid ReadGridOf(const PlannedPath& path, StageContext& context) {
  const auto floors = ReadFloors(context.Input("grid"));
  const auto floor_idx = FindFloor(floors, path.floor);
  if (!floor_idx) {
    throw DataError("{}: the path is on floor {}, but the map has {}: run make plan again",
                    context.Input("json").string(),
                    path.floor,
                    FloorsText(floors));
  }
  return ReadFloorGrid(context, "grid", floors[*floor_idx]);
}

void Run(const DriveOptions& options, StageContext& context) {
  context.BeginPart("read");
  const auto path = ReadPlannedPath(context.Input("csv"), context.Input("json"));
  const DriveInputs inputs{ReadGridOf(path, context), path};
  context.BeginPart("drive");
  const DriveResult result = RunDrive(options, inputs, context.GetProgress());
  context.BeginPart("write");
  const auto json = DriveToJson(result, context.ConfigToml());
  WriteFile(context.Output("csv"), DriveToCsv(result));
  WriteFile(context.Output("json"), json.dump(2) + "\n");
  if (context.HasOutput("gif")) {
    WriteGif(context.Output("gif"), DrawDrive(inputs, result), kDriveImagesPerS);
  }
  context.Report().update(DriveFigures(result));
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{
      "drive",
      "lets a simulated robot follow the planned path",
      {{"grid", "floors.json of the grid stage, or an imported map.yaml"},
       {"csv", "path.csv of the plan stage"},
       {"json", "path.json of the plan stage"}},
      {{"csv", "poses and commands: time_ns,x_m,y_m,heading_rad,v_m_s,omega_rad_s"},
       {"json", "figures of the drive"},
       {"gif", "animation of the drive on the grid", Arity::kOptional}}};
  return StageMain(argc, argv, spec, DriveOptions{}, Run);
}
