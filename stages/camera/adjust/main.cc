// SPDX-License-Identifier: Apache-2.0
// adjust: turns the closed pose graph and the features into the final trajectory and cameras.
#include "stages/camera/adjust/adjust.h"

#include "pipeline/geometry/bundle_report.h"
#include "pipeline/graph/frame_poses.h"
#include "pipeline/program/stage_main.h"
#include "stages/camera/adjust/adjust_output.h"

namespace nightmap {
namespace {

AdjustInput ReadInput(const StageContext& context) {
  AdjustInput input;
  input.frames = ReadFrames(context.Inputs("frames"));
  input.cameras = ReadCameras(context.Input("cameras"), input.frames);
  input.features = SiteFeatures(context.Inputs("features"), context.Inputs("frames"));
  const auto odometry = context.Inputs("odometry");
  input.num_shards = odometry.size();
  input.odometry = [odometry](std::size_t shard) { return ReadOdometry(odometry.at(shard)); };
  input.loops = [loops = context.Input("loops")] { return ReadPairs(loops); };
  input.graph = ReadClosedGraph(context.Input("graph"));
  return input;
}

void Run(const AdjustOptions& options, StageContext& context) {
  const AdjustInput input = ReadInput(context);
  const auto result = RunAdjust(options, input, context.GetProgress(), context.NumThreads());
  WarnOfStalls(result.adjustments);
  context.WriteIfWanted("g2o", [&] { return PoseGraphToG2o(result.graph); });
  WriteFile(context.Output("trajectory"), TrajectoryText(input.frames, result.graph_from_camera));
  WriteFile(context.Output("keyframes"),
            KeyframesText(input.frames, result.graph_from_camera, result.keyframes));
  WriteFile(context.Output("cameras"), CamerasToJson(CalibratedCameras(input, result)));
  context.Report().update(Summarize(options, input, result));
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"adjust",
                       "Adjusts the trajectory and the cameras by the features.",
                       {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
                        {"cameras", "cameras.json of the frames stage"},
                        {"features", "shard_NNNN.h5 of the features stage", Arity::kMany},
                        {"odometry", "shard_NNNN.h5 of the odometry stage", Arity::kMany},
                        {"loops", "loops.h5 of the loops stage"},
                        {"graph", "graph.h5 of the pose_graph stage"}},
                       {{"g2o", "graph.g2o: keyframes and edges", Arity::kOptional},
                        {"trajectory", "trajectory.tum: graph_from_camera of every frame"},
                        {"keyframes", "keyframes.tum: graph_from_camera of the keyframes"},
                        {"cameras", "cameras.json with the estimated focal lengths"}}};
  return StageMain(argc, argv, spec, AdjustOptions{}, Run);
}
