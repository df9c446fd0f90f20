// SPDX-License-Identifier: Apache-2.0
// pose_graph: turns odometry and loops of all shards into a graph with its loops closed.
#include "stages/graph/pose_graph/pose_graph.h"

#include "pipeline/graph/frame_poses.h"
#include "pipeline/program/stage_main.h"
#include "stages/graph/pose_graph/adopt_odometry.h"
#include "stages/graph/pose_graph/pose_graph_output.h"
#include "stages/graph/pose_graph/sensor_warnings.h"

namespace nightmap {
namespace {

PoseGraphInput ReadInput(const StageContext& context) {
  PoseGraphInput input;
  input.frames = ReadFrames(context.Inputs("frames"));
  for (const auto& path : context.Inputs("odometry")) {
    input.odometry.push_back(ReadOdometryWithoutTracks(path));
  }
  if (context.HasInput("loops")) input.loops = ReadCountedPairs(context.Input("loops"));
  for (const auto& path : context.Inputs("edges")) input.edges.push_back(ReadEdges(path));
  if (input.frames.empty()) AdoptOdometry(&input);
  return input;
}

void Run(const PoseGraphOptions& options, StageContext& context) {
  const PoseGraphInput input = ReadInput(context);
  const auto result = RunPoseGraph(options, input, context.GetProgress());
  const OdometryChain& chain = result.graph.chain;
  WriteClosedGraph(context.Output("graph"), result.graph, context.ConfigToml());
  WriteFile(context.Output("trajectory"), TrajectoryText(input.frames, result.graph_from_camera));
  WriteFile(context.Output("keyframes"),
            KeyframesText(input.frames, result.graph_from_camera, chain.keyframes));
  LogWarnings(result.sensors);
  context.WriteIfWanted("loops_csv", [&] { return LoopsToCsv(result.loops); });
  context.Report().update(Summarize(input, result));
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "pose_graph",
      "Computes one consistent trajectory of all shards with loops closed.",
      {{"frames", "shard_NNNN.csv of all shards, in order; none: no camera", Arity::kAnyNumber},
       {"odometry", "shard_NNNN.h5 of the odometry stage", Arity::kAnyNumber},
       {"loops", "loops.h5 of the loops stage", Arity::kOptional},
       {"edges",
        "edges.h5 of another sensor, its nodes being frames; without a camera the odometry of the "
        "first makes the nodes",
        Arity::kAnyNumber}},
      {{"graph", "graph.h5: odometry, keyframes and edges, for the adjust stage"},
       {"trajectory", "trajectory.tum: graph_from_camera of every frame"},
       {"keyframes", "keyframes.tum: graph_from_camera of the keyframes"},
       {"loops_csv", "loops.csv: every loop candidate and the decision on it", Arity::kOptional}}};
  return StageMain(argc, argv, spec, PoseGraphOptions{}, Run);
}
