// SPDX-License-Identifier: Apache-2.0
// map_frame: moves trajectory and keyframes from their own frame to the map frame.
#include "stages/dense/map_frame/map_frame.h"

#include "pipeline/io/frame_reader.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/dense/map_frame/describe_floor.h"

namespace nightmap {
namespace {

std::string InMapFrame(std::vector<StampedPose> poses, const MapFrame& frame) {
  for (StampedPose& stamped : poses) stamped.pose = frame.map_from_given * stamped.pose;
  return TrajectoryToTum(poses, "map_from_camera; map frame: z up, floor at z = 0");
}

void Run(const MapFrameOptions& options, StageContext& context) {
  const auto trajectory = ReadPoses(context.Input("trajectory"));
  MapFrameInput input;
  input.keyframes = ReadPoses(context.Input("keyframes"));
  input.frames = ReadFrames(context.Inputs("frames"));
  input.cameras = ReadCameras(context.Input("cameras"), input.frames);
  if (context.HasInput("acceleration")) {
    input.accelerometer = ReadAcceleration(context.Input("acceleration"));
  }
  const FrameReader reader(context.Input("data"), context.Inputs("masks"));
  input.load_depth = [&](const FrameRecord& frame) {
    return reader.Depth(frame, input.cameras.at(static_cast<std::size_t>(frame.camera_idx)));
  };
  const MapFrame frame = RunMapFrame(options, input, context.NumThreads());
  LogFloor(frame);
  WriteFile(context.Output("trajectory"), InMapFrame(trajectory, frame));
  WriteFile(context.Output("keyframes"), InMapFrame(input.keyframes, frame));
  context.Report().update(Summarize(frame));
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "map_frame",
      "Moves a finished trajectory to the map frame: z up, floor at z = 0.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the adjust stage"},
       FolderPort("data", "folder to which the paths in the frames files are relative"),
       {"masks", "shard_NNNN.h5 of masks: what moves in the frames", Arity::kAnyNumber},
       {"trajectory", "trajectory.tum, in any frame of reference"},
       {"keyframes", "keyframes.tum: its poses at the times of some frames"},
       {"acceleration", "acceleration.h5 of the frames stage", Arity::kOptional}},
      {{"trajectory", "trajectory.tum: map_from_camera of every pose"},
       {"keyframes", "keyframes.tum: map_from_camera of the keyframes"}}};
  return StageMain(argc, argv, spec, MapFrameOptions{}, Run);
}
