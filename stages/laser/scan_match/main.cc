// SPDX-License-Identifier: Apache-2.0
// scan_match: reads scans and odometry; writes the robot's trajectory and its edges.
#include "stages/laser/scan_match/scan_match.h"

#include <algorithm>

#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const ScanMatchOptions& options, StageContext& context) {
  ScanMatchInput input;
  input.scans = ReadSignals(context.Input("scans"), SignalKind::kScan);
  if (context.HasInput("odometry")) {
    input.odometry = ReadSignals(context.Input("odometry"), SignalKind::kOdometry);
  }
  const ScanMatchResult result = RunScanMatch(options, input, context.GetProgress());
  std::vector<StampedPose> poses, keyscans;
  for (const MatchedScan& scan : result.scans) {
    poses.push_back({scan.time_ns, scan.start_from_robot.ToRigid3()});
    if (scan.is_keyscan) keyscans.push_back(poses.back());
    if (!scan.is_matched) {
      context.Skip(
          fmt::format("scan at {:.3f} s: fits nowhere", 1e-9 * static_cast<double>(scan.time_ns)));
    }
  }
  context.CheckSkipped(result.scans.size(), options.max_failed_ratio, {{"scans"}});
  WriteEdges(context.Output("edges"), result.edges, context.ConfigToml());
  const std::string comment = "start_from_robot at each scan";
  WriteFile(context.Output("trajectory"), TrajectoryToTum(poses, comment));
  WriteFile(context.Output("keyframes"), TrajectoryToTum(keyscans, comment));
  auto& report = context.Report();
  report["scan_sensor"] = result.scan_sensor;
  report["odometry_sensor"] = result.odometry_sensor;
  report["num_scans"] = result.scans.size();
  report["num_keyscans"] = keyscans.size();
  report["num_scans_unclear"] = std::ranges::count_if(
      result.scans, [](const MatchedScan& scan) { return scan.unclear_in_robot.has_value(); });
  if (result.wheel_scale) report["wheel_scale"] = *result.wheel_scale;
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"scan_match",
                       "Finds the robot's way by matching each laser scan to those before it.",
                       {{"scans", "scans.h5 of the frames stage"},
                        {"odometry", "odometry.h5 of the frames stage", Arity::kOptional}},
                       {{"edges", "edges.h5: the robot's motion between consecutive keyscans"},
                        {"trajectory", "trajectory.tum: start_from_robot at each scan"},
                        {"keyframes", "keyframes.tum: likewise at each keyscan"}}};
  return StageMain(argc, argv, spec, ScanMatchOptions{}, Run);
}
