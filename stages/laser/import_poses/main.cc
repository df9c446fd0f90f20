// SPDX-License-Identifier: Apache-2.0
// import_poses: reads scans and poses of the robot; writes the poses at the scans as map_frame
// does.
#include "stages/laser/import_poses/import_poses.h"

#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const ImportPosesOptions& options, StageContext& context) {
  const ImportPosesInput input{ReadSignals(context.Input("scans"), SignalKind::kScan),
                               ReadGivenPoses(options, context.Input("given"))};
  const ImportPosesResult result = RunImportPoses(options, input);
  for (const std::string& text : result.skipped) context.Skip(text);
  context.CheckSkipped(result.num_scans, options.max_failed_ratio, {{"given"}, {"scans"}});
  const std::string text =
      TrajectoryToTum(result.poses, "map_from_robot at each scan, of another system");
  WriteFile(context.Output("trajectory"), text);
  WriteFile(context.Output("keyframes"), text);
  context.Report()["num_scans"] = result.num_scans;
  context.Report()["num_scans_with_pose"] = result.poses.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "import_poses",
      "Imports the robot's poses that another system made of a laser log.",
      {{"scans", "scans.h5 of the frames stage"},
       CheckedPort("given",
                   "TUM file (.tum, .txt) of map_from_robot, or a CARMEN log with corrected poses",
                   CheckGivenPoses)},
      {{"trajectory", "trajectory.tum: map_from_robot at each scan"},
       {"keyframes", "keyframes.tum: the same"}}};
  return StageMain(argc, argv, spec, ImportPosesOptions{}, Run);
}
