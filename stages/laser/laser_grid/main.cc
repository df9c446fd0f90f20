// SPDX-License-Identifier: Apache-2.0
// laser_grid: reads scans and the trajectory of the robot; writes the grid as the grid stage writes
// its own, as one floor at z = 0.
#include "stages/laser/laser_grid/laser_grid.h"

#include "pipeline/io/trajectory_io.h"
#include "pipeline/plan/floors_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const LaserGridOptions& options, StageContext& context) {
  context.BeginPart("read");
  const LaserGridInput input{ReadSignals(context.Input("scans"), SignalKind::kScan),
                             ReadTum(context.Input("trajectory"))};
  context.BeginPart("fill");
  const LaserGridResult result = RunLaserGrid(options, input);
  for (const std::string& text : result.skipped) context.Skip(text);
  context.CheckSkipped(result.num_scans, options.max_failed_ratio, {{"scans"}, {"trajectory"}});
  context.BeginPart("write");
  WriteOneFloor(result.map.grid, context);
  context.Report() = DescribeLaserGrid(result);
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"laser_grid",
                       "makes the grid of the site from the scans of a laser scanner",
                       {{"scans", "scans.h5 of the frames stage"},
                        {"trajectory", "TUM file of map_from_robot poses"}},
                       {{"floors", "floors.json: one floor at z = 0"},
                        {"pgm", "grid: 254 free, 0 occupied, 205 unknown"},
                        {"yaml", "map_server's description of that image"},
                        {"png", "the grid as a picture"}}};
  return StageMain(argc, argv, spec, LaserGridOptions{}, Run);
}
