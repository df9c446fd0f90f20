// SPDX-License-Identifier: Apache-2.0
// drive: a simulated differential-drive robot follows the planned path. Reads map.yaml with
// map.pgm, path.csv and path.json; writes drive.csv, drive.json and drive.gif.
#include "pipeline/base/files.h"
#include "pipeline/base/stage_main.h"
#include "stages/drive/drive.h"
#include "stages/drive/drive_output.h"

namespace {

using namespace nightmap;

void Run(const DriveOptions& options, StageContext& context) {
  context.BeginPart("read");
  const DriveInputs inputs{ReadGrid(context.Input("yaml"), context.Input("pgm")),
                           ReadPlannedPath(context.Input("csv"), context.Input("json"))};
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
      {{"yaml", "map.yaml of the grid stage, or an imported map_server map"},
       {"pgm", "the image that the yaml names"},
       {"csv", "path.csv of the plan stage"},
       {"json", "path.json of the plan stage"}},
      {{"csv", "poses and commands: time_ns,x_m,y_m,heading_rad,v_m_s,omega_rad_s"},
       {"json", "the drive's figures"},
       {"gif", "the drive on the grid", Arity::kOptional}}};
  return StageMain(argc, argv, spec, DriveOptions{}, Run);
}
