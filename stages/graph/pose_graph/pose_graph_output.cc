// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/pose_graph_output.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/io/csv.h"
#include "stages/graph/pose_graph/sensor_warnings.h"

namespace nightmap {

std::string LoopsToCsv(const std::vector<LoopRecord>& loops) {
  std::string text = "frame_a,frame_b,status,reason,score,num_putative,num_inliers,drift,error\n";
  for (const LoopRecord& loop : loops) {
    text += fmt::format("{},{},{},{},{:.6f},{},{},{:.4f},{:.4f}\n",
                        loop.frame_a,
                        loop.frame_b,
                        loop.is_accepted ? "accepted" : "rejected",
                        CsvField(loop.reason),
                        loop.score,
                        loop.num_putative,
                        loop.num_inliers,
                        loop.drift,
                        loop.error);
  }
  return text;
}

namespace {

nlohmann::json SensorReport(const std::vector<SensorRecord>& sensors) {
  auto all = nlohmann::json::array();
  for (const SensorRecord& record : sensors) {
    all.push_back({{"sensor", record.sensor},
                   {"num_edges", record.num_odometry + record.num_loops + record.num_priors},
                   {"num_odometry", record.num_odometry},
                   {"num_loops", record.num_loops},
                   {"num_priors", record.num_priors},
                   {"num_refused", record.num_refused},
                   {"median_normalized_residual", record.median_residual},
                   {"warnings", record.warnings}});
    if (record.calibration) all.back()["calibration"] = Summarize(*record.calibration);
  }
  return all;
}

nlohmann::json OptimizationReport(const GraduationSummary& summary) {
  return {{"num_rounds", summary.num_rounds},
          {"initial_cost", summary.last.initial_cost},
          {"final_cost", summary.last.final_cost},
          {"num_steps", summary.last.num_steps},
          {"has_converged", summary.last.has_converged}};
}

}  // namespace

nlohmann::json Summarize(const PoseGraphInput& input, const PoseGraphResult& result) {
  const auto num_accepted = std::ranges::count_if(result.loops, &LoopRecord::is_accepted);
  const auto num_rejected = std::ranges::count_if(
      input.loops, [](const CountedPair& loop) { return loop.status != PairStatus::kAccepted; });
  const auto num_bridges = std::ranges::count_if(result.edges, &PoseEdge::is_bridge);
  auto parts = nlohmann::json::array();
  for (const GraphPart& part : result.parts) {
    parts.push_back({{"num_frames", part.num_frames}, {"runs", part.runs}});
  }
  nlohmann::json report = {
      {"parts", parts},
      {"connection",
       result.parts.size() == 1 ? "whole" : "guessed motion joins the parts: no loop does"},
      {"returns_to_start", result.returns_to_start},
      {"num_frames", input.frames.size()},
      {"num_keyframes", result.graph.graph_from_keyframe.size()},
      {"num_edges", result.edges.size()},
      {"num_bridges", num_bridges},
      {"num_loop_candidates", result.loops.size()},
      {"num_loops_verified", std::ssize(result.loops) - num_rejected},
      {"num_loops_accepted", num_accepted},
      {"loops", num_accepted > 0 ? "closed" : "no loop found: the map is held by odometry alone"},
      {"graph_optimization", OptimizationReport(result.optimization)}};
  if (!result.sensors.empty()) report["sensors"] = SensorReport(result.sensors);
  return report;
}

}  // namespace nightmap
