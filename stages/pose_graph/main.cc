// SPDX-License-Identifier: Apache-2.0
// pose_graph: turns odometry and loops of all shards into graph and trajectory.
#include "stages/pose_graph/pose_graph.h"

#include "pipeline/geometry/bundle_report.h"
#include "pipeline/program/stage_main.h"
#include "stages/pose_graph/pose_graph_output.h"

namespace nightmap {
namespace {

PoseGraphInput ReadInput(const StageContext& context) {
  PoseGraphInput input;
  input.frames = ReadFrames(context.Inputs("frames"));
  input.cameras = ReadCameras(context.Input("cameras"), input.frames);
  input.features = ReadFeatures(context.Inputs("features"), context.Inputs("frames"));
  for (const auto& path : context.Inputs("odometry")) input.odometry.push_back(ReadOdometry(path));
  input.loops = ReadPairs(context.Input("loops"));
  for (const auto& path : context.Inputs("edges")) input.edges.push_back(ReadEdges(path));
  return input;
}

void Run(const PoseGraphOptions& options, StageContext& context) {
  const PoseGraphInput input = ReadInput(context);
  const auto result = RunPoseGraph(options, input, context.NumThreads(), context.GetProgress());
  WarnOfStalls(result.adjustments);
  context.WriteIfWanted("graph", [&] { return PoseGraphToG2o(result.graph); });
  WriteFile(context.Output("trajectory"), TrajectoryText(input, result, false));
  WriteFile(context.Output("keyframes"), TrajectoryText(input, result, true));
  WriteFile(context.Output("cameras"), CamerasToJson(CalibratedCameras(input, result)));
  context.WriteIfWanted("loops_csv", [&] { return LoopsToCsv(result.loops); });
  context.Report().update(Summarize(options, input, result));
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "pose_graph",
      "Computes one consistent trajectory of all shards with loops closed.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"features", "shard_NNNN.h5 of the features stage", Arity::kMany},
       {"odometry", "shard_NNNN.h5 of the odometry stage", Arity::kMany},
       {"loops", "loops.h5 of the loops stage"},
       {"edges", "edges.h5 of another sensor, its nodes being frames", Arity::kAnyNumber}},
      {{"graph", "graph.g2o: keyframes and edges", Arity::kOptional},
       {"trajectory", "trajectory.tum: graph_from_camera of every frame"},
       {"keyframes", "keyframes.tum: graph_from_camera of the keyframes"},
       {"cameras", "cameras.json of the frames stage with the estimated focal lengths"},
       {"loops_csv", "loops.csv: every loop candidate and the decision on it", Arity::kOptional}}};
  return StageMain(argc, argv, spec, PoseGraphOptions{}, Run);
}
