// SPDX-License-Identifier: Apache-2.0
// import_trajectory: reads the lists of frames, their features and a TUM trajectory of another
// system; writes it as pose_graph writes its own.
#include "stages/camera/import_trajectory/import_trajectory.h"

#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const ImportTrajectoryOptions& options, StageContext& context) {
  const FramesWithFeatures input = ReadFramesWithFeatures(
      context.Inputs("frames"), context.Input("cameras"), context.Inputs("features"));
  const std::string file = context.Input("given").string();
  const auto given = ReadTum(file);
  const auto result = RunImportTrajectory(options, input.frames, given);
  JudgeNumPosed(options, input.frames, given, result.poses.size(), file);
  auto& report = context.Report();
  if (options.check_motion) {
    const auto motions =
        MeasureMotions(input, result.poses, context.NumThreads(), context.GetProgress());
    const MotionVerdict verdict = CompareMotions(given, motions);
    JudgeMotions(verdict, file);
    report["num_motions"] = verdict.num_motions;
    report["num_agreeing_motions"] = verdict.num_agreeing;
    report["scale"] = verdict.scale;
  }
  JudgeJumps(FindPoseJumps(given), file);
  const std::string comment = "given_from_camera, of another system";
  WriteFile(context.Output("trajectory"), TrajectoryToTum(result.poses, comment));
  WriteFile(context.Output("keyframes"), TrajectoryToTum(result.keyframes, comment));
  report["num_frames"] = input.frames.size();
  report["num_frames_with_pose"] = result.poses.size();
  report["num_keyframes"] = result.keyframes.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "import_trajectory",
      "Imports a trajectory of the frames that another system made.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"features", "shard_NNNN.h5 of the features stage, in the same order", Arity::kMany},
       CheckedPort("given",
                   "TUM file: poses of the color camera in one frame, at the recording's times",
                   [](const std::filesystem::path& file) { ReadTum(file); })},
      {{"trajectory", "trajectory.tum: given_from_camera of every frame that has one"},
       {"keyframes", "keyframes.tum: given_from_camera of the keyframes"}}};
  return StageMain(argc, argv, spec, ImportTrajectoryOptions{}, Run);
}
