// SPDX-License-Identifier: Apache-2.0
// carry_scans: reads the robot's way by scan matching and the keyscans of the graph; writes the
// robot's way in the map.
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/laser/carry_scans/carry_scans.h"

namespace nightmap {
namespace {

void Run(const CarryScansOptions&, StageContext& context) {
  const CarryScansInput input{ReadPoses(context.Input("scans")),
                              ReadPoses(context.Input("keyframes"))};
  const std::vector<StampedPose> poses = RunCarryScans(input);
  const std::string comment = "map_from_robot; z up, the robot drives at z = 0";
  WriteFile(context.Output("trajectory"), TrajectoryToTum(poses, comment));
  WriteFile(context.Output("keyframes"), TrajectoryToTum(input.keyscans, comment));
  context.Report()["num_scans"] = poses.size();
  context.Report()["num_keyscans"] = input.keyscans.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "carry_scans",
      "Moves the robot's way at every scan to where the graph put its keyscans.",
      {{"scans", "trajectory.tum of scan_match: start_from_robot at each scan"},
       {"keyframes", "keyframes.tum of pose_graph: graph_from_robot at each keyscan"}},
      {{"trajectory", "trajectory.tum: map_from_robot at each scan"},
       {"keyframes", "keyframes.tum: likewise at each keyscan"}}};
  return StageMain(argc, argv, spec, CarryScansOptions{}, Run);
}
