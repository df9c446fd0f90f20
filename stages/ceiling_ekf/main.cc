// SPDX-License-Identifier: Apache-2.0
// ceiling_ekf: reads tracks of corners and odometry; writes the robot's trajectory and the map of
// the ceiling.
#include "pipeline/ceiling/join_tracks.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/ceiling_ekf/ceiling_ekf.h"
#include "stages/ceiling_ekf/ceiling_ekf_report.h"

namespace nightmap {
namespace {

constexpr double kSamePixel_px = 1;  // of one corner, tracked in one shard and found in the next

void Run(const CeilingEkfOptions& options, StageContext& context) {
  const std::vector<FrameRecord> frames = ReadFrames(context.Inputs("frames"));
  CeilingEkfInput input;
  input.camera = OneCamera(frames, ReadCameras(context.Input("cameras"), frames));
  std::vector<CornerTracks> shards;
  for (const auto& path : context.Inputs("tracks")) shards.push_back(ReadCornerTracks(path));
  input.tracks = JoinTracks(std::move(shards), kSamePixel_px);
  if (context.HasInput("odometry")) {
    input.odometry = ReadSignals(context.Input("odometry"), SignalKind::kOdometry);
  }
  const CeilingEkfResult result = RunCeilingEkf(options, input, context.GetProgress());
  std::vector<StampedPose> poses;
  for (const CeilingFrame& frame : result.map.frames) {
    poses.push_back({frame.time_ns, frame.map_from_robot.ToRigid3()});
  }
  WriteFile(context.Output("trajectory"), TrajectoryToTum(poses, "map_from_robot at each frame"));
  WriteCeilingMap(context.Output("map"), result.map, context.ConfigToml());
  WriteFile(context.Output("ply"), LandmarksToPly(result.map.landmarks));
  context.Report().update(Summarize(result));
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "ceiling_ekf",
      "Finds the robot's way and the landmarks of the ceiling, by EKF-SLAM.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"tracks", "shard_NNNN.h5 of ceiling_tracks, of all shards, in order", Arity::kMany},
       {"odometry", "odometry.h5 of the frames stage", Arity::kOptional}},
      {{"trajectory", "trajectory.tum: map_from_robot at each frame; the map is its first pose"},
       {"map", "ceiling_map.h5: landmarks, anchors, loops, what the filter said at each frame"},
       {"ply", "landmarks.ply: the landmarks, for viewers"}}};
  return StageMain(argc, argv, spec, CeilingEkfOptions{}, Run);
}
