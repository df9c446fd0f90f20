// SPDX-License-Identifier: Apache-2.0
// ghosts: reads the poses of the keyframes, their depth, and masks of what moves and what may;
// writes the masks that the map is made under, and the list of frames with them.
#include "pipeline/dense/rgbd_keyframes.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/labels/ghosts/ghosts_output.h"

namespace nightmap {
namespace {

void Run(const GhostsOptions& options, StageContext& context) {
  const auto frames = ReadFrames(context.Inputs("frames"));
  GhostsInput input;
  input.cameras = ReadCameras(context.Input("cameras"), frames);
  input.keyframes =
      SelectKeyframes(frames, input.cameras, ReadPoses(context.Input("keyframes")), 1);
  const FrameReader moving(context.Input("data"), context.Inputs("masks"));
  const FrameReader may_move(context.Input("data"), context.Inputs("may_move"));
  const auto camera = [&](const Keyframe& keyframe) -> const RgbdCamera& {
    return input.cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)];
  };
  input.depth = [&](const Keyframe& k) { return moving.Depth(k.frame, camera(k)); };
  input.moving = [&](const Keyframe& k) { return moving.Mask(k.frame, camera(k)); };
  input.may_move = [&](const Keyframe& k) { return may_move.Mask(k.frame, camera(k)); };
  const auto result = RunGhosts(options, input, context.GetProgress(), context.NumThreads());
  for (const std::string& reason : result.skipped) context.Skip(reason);
  context.CheckSkipped(input.keyframes.size(), options.max_failed_ratio);
  WriteGhosts(result, frames, context);
  context.Report()["num_keyframes"] = input.keyframes.size();
  context.Report()["num_regions"] = result.num_regions;
  context.Report()["num_ghosts"] = result.num_ghosts;
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"ghosts",
                       "Masks in keyframes what stands still there and is gone at another time.",
                       {{"frames", "shard_NNNN.csv of the moving stage", Arity::kMany},
                        {"cameras", "cameras.json of the adjust stage"},
                        {"keyframes", "keyframes.tum of the map_frame stage, map_from_camera"},
                        FolderPort("data", "folder to which the frames' paths are relative"),
                        {"masks", "masks of what moves", Arity::kAnyNumber, PortKind::kByHash},
                        {"may_move", "masks of what labels say may move", Arity::kAnyNumber}},
                       {{"masks", "masks of what moves in keyframes, and of ghosts"},
                        {"frames", "the list of frames, with these masks"}}};
  return StageMain(argc, argv, spec, GhostsOptions{}, Run);
}
