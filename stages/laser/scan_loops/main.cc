// SPDX-License-Identifier: Apache-2.0
// scan_loops: reads scans and what scan_match made of them; writes loops as edges.
#include "stages/laser/scan_loops/scan_loops.h"

#include <algorithm>

#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const ScanLoopsOptions& options, StageContext& context) {
  ScanLoopsInput input{ReadSignals(context.Input("scans"), SignalKind::kScan),
                       ReadPoses(context.Input("keyframes")),
                       ReadEdges(context.Input("odometry"))};
  const ScanLoopsResult result =
      RunScanLoops(options, std::move(input), context.GetProgress(), context.NumThreads());
  WriteEdges(context.Output("edges"), result.edges, context.ConfigToml());
  const auto count = [&](auto is) { return std::ranges::count_if(result.candidates, is); };
  auto& report = context.Report();
  report["num_submaps"] = result.num_submaps;
  report["num_queries"] = result.num_queries;
  report["num_pairs_tried"] = result.candidates.size();
  report["num_found_nowhere"] = count([](const auto& tried) { return tried.score == 0; });
  report["num_ambiguous"] = count([](const auto& tried) { return tried.second_score > 0; });
  report["num_doubtful"] = count([](const auto& tried) {
    return tried.score > 0 && tried.second_score == 0 && !tried.is_loop;
  });
  report["num_loops"] = result.edges.edges.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"scan_loops",
                       "Finds places that the robot came back to, by its laser scans.",
                       {{"scans", "scans.h5 of the frames stage"},
                        {"keyframes", "keyframes.tum of scan_match"},
                        {"odometry", "edges.h5 of scan_match"}},
                       {{"edges", "edges.h5: loops between keyscans"}}};
  return StageMain(argc, argv, spec, ScanLoopsOptions{}, Run);
}
