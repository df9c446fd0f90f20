// SPDX-License-Identifier: Apache-2.0
// ceiling_ekf: reads tracks of corners and odometry; writes the robot's trajectory and the map of
// the ceiling.
#include <utility>

#include "pipeline/ceiling/ceiling_files.h"
#include "pipeline/program/stage_main.h"
#include "stages/ceiling/ceiling_ekf/ceiling_ekf.h"
#include "stages/ceiling/ceiling_ekf/ceiling_ekf_report.h"

namespace nightmap {
namespace {

void Run(const CeilingEkfOptions& options, StageContext& context) {
  CeilingTracks read = ReadCeilingTracks(context);
  CeilingEkfInput input{std::move(read.tracks), read.camera, {}};
  if (context.HasInput("odometry")) {
    input.odometry = ReadSignals(context.Input("odometry"), SignalKind::kOdometry);
  }
  const CeilingEkfResult result = RunCeilingEkf(options, input, context.GetProgress());
  WriteCeiling(result.map, context);
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
