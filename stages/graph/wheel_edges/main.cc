// SPDX-License-Identifier: Apache-2.0
// wheel_edges: reads frames, cameras and odometry; writes the edges of one sensor.
#include "stages/graph/wheel_edges/wheel_edges.h"

#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const WheelEdgesOptions& options, StageContext& context) {
  WheelEdgesInput input;
  input.frames = ReadFrames(context.Inputs("frames"));
  input.cameras = ReadCameras(context.Input("cameras"), input.frames);
  input.odometry = ReadSignals(context.Input("odometry"), SignalKind::kOdometry);
  const WheelEdgesResult result = RunWheelEdges(options, input);
  WriteEdges(context.Output("edges"), result.edges, context.ConfigToml());
  auto& report = context.Report();
  report["sensor"] = result.edges.sensor;
  report["num_frames"] = input.frames.size();
  report["num_edges"] = result.edges.edges.size();
  report["num_motions_without_edge"] =
      static_cast<std::size_t>(result.num_motions) - result.edges.edges.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "wheel_edges",
      "Turns the odometry of the wheels into edges between frames.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"odometry", "odometry.h5 of the frames stage"}},
      {{"edges", "edges.h5: the motion between consecutive frames, for pose_graph"}}};
  return StageMain(argc, argv, spec, WheelEdgesOptions{}, Run);
}
