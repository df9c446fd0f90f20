// SPDX-License-Identifier: Apache-2.0
// import_trajectory: reads the lists of frames and a TUM trajectory of another system; writes it as
// pose_graph writes its own.
#include "stages/import_trajectory/import_trajectory.h"

#include "pipeline/io/frames_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "import_trajectory",
      "Imports a trajectory of the frames that another system made.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"given", "TUM file: poses of the color camera in one frame, at the recording's times"}},
      {{"trajectory", "trajectory.tum: given_from_camera of every frame that has one"},
       {"keyframes", "keyframes.tum: given_from_camera of the keyframes"},
       {"cameras", "cameras.json, the same as that of the frames stage"}}};
  return StageMain(
      argc,
      argv,
      spec,
      ImportTrajectoryOptions{},
      [](const ImportTrajectoryOptions& options, StageContext& context) {
        const auto frames = ReadFrames(context.Inputs("frames"));
        const auto result = RunImportTrajectory(options, frames, ReadTum(context.Input("given")));
        const std::string comment = "given_from_camera, of another system";
        WriteFile(context.Output("trajectory"), TrajectoryToTum(result.poses, comment));
        WriteFile(context.Output("keyframes"), TrajectoryToTum(result.keyframes, comment));
        WriteFile(context.Output("cameras"),
                  CamerasToJson(ReadCameras(context.Input("cameras"), frames)));
        context.Report()["num_frames"] = frames.size();
        context.Report()["num_frames_with_pose"] = result.poses.size();
        context.Report()["num_keyframes"] = result.keyframes.size();
      });
}
