// SPDX-License-Identifier: Apache-2.0
// hold_out_scans: reads scans and the robot's way; writes the scans that stay in a test map, and
// the others as queries with their true poses.
#include "stages/laser/hold_out_scans/hold_out_scans.h"

#include <spdlog/spdlog.h>

#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const HoldOutScansOptions& options, StageContext& context) {
  const HoldOutScansInput input{ReadSignals(context.Input("scans"), SignalKind::kScan),
                                ReadPoses(context.Input("trajectory"))};
  const HeldOutScans result = RunHoldOutScans(options, input);
  WriteSignals(context.Output("scans"), SignalKind::kScan, result.mapped);
  WriteScanQueries(context.Output("queries"), result.queries);
  WriteFile(context.Output("truth"),
            TrajectoryToTum(result.truth, "map_from_robot at the times of the queries"));
  if (result.queries.empty()) {
    spdlog::warn(
        "no scan is left to ask for: the way is shorter than {} blocks of {} m, or leads nowhere "
        "twice; lower hold_out_scans.block_m or raise near_m",
        options.every,
        options.block_m);
  }
  if (result.num_left_out > 0) {
    spdlog::warn("{} queries are left out; raise hold_out_scans.max_queries to ask for more",
                 result.num_left_out);
  }
  auto& report = context.Report();
  report["num_scans"] = result.mapped[0].samples.size();
  report["num_held_out"] = result.num_held_out;
  report["num_far"] = result.num_far;
  report["num_queries"] = result.queries.size();
  report["num_queries_left_out"] = result.num_left_out;
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"hold_out_scans",
                       "holds stretches of the robot's way out of a map, to ask where they are",
                       {{"scans", "scans.h5 of the frames stage"},
                        {"trajectory", "trajectory.tum: map_from_robot at the scans"}},
                       {{"scans", "scans.h5 without the scans that are held out"},
                        {"queries", "queries.h5: scans that are held out"},
                        {"truth", "truth.tum: map_from_robot at the times of the queries"}}};
  return StageMain(argc, argv, spec, HoldOutScansOptions{}, Run);
}
