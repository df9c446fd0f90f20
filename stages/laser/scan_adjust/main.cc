// SPDX-License-Identifier: Apache-2.0
// scan_adjust: reads scans and the closed graph; writes its keyscans, adjusted.
#include "stages/laser/scan_adjust/scan_adjust.h"

#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const ScanAdjustOptions& options, StageContext& context) {
  ScanAdjustInput input{ReadSignals(context.Input("scans"), SignalKind::kScan),
                        ReadPoses(context.Input("keyframes")),
                        ReadEdges(context.Input("odometry"))};
  const ScanAdjustResult result =
      RunScanAdjust(options, std::move(input), context.GetProgress(), context.NumThreads());
  constexpr int kNumDecimals = 15;  // carry_scans goes on with these poses
  WriteFile(context.Output("keyframes"),
            TrajectoryToTum(result.keyscans, "graph_from_robot at each keyscan", kNumDecimals));
  auto& report = context.Report();
  report["num_keyscans"] = result.keyscans.size();
  report["num_pairs"] = result.num_pairs;
  report["num_matches"] = result.num_matches;
  report["rms_m"] = result.rms_m;
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"scan_adjust",
                       "Moves the keyscans so that all scans of a place agree on its walls.",
                       {{"scans", "scans.h5 of the frames stage"},
                        {"keyframes", "keyframes.tum of pose_graph: graph_from_robot"},
                        {"odometry", "edges.h5 of scan_match"}},
                       {{"keyframes", "keyframes.tum: graph_from_robot, adjusted"}}};
  return StageMain(argc, argv, spec, ScanAdjustOptions{}, Run);
}
