// SPDX-License-Identifier: Apache-2.0
// ceiling_adjust: reads tracks of corners, odometry and what the filter made of them; writes the
// adjusted trajectory and map.
#include <utility>

#include "pipeline/ceiling/ceiling_files.h"
#include "pipeline/program/stage_main.h"
#include "stages/ceiling/ceiling_adjust/ceiling_adjust.h"
#include "stages/ceiling/ceiling_adjust/ceiling_adjust_report.h"

namespace nightmap {
namespace {

void Run(const CeilingAdjustOptions& options, StageContext& context) {
  CeilingTracks read = ReadCeilingTracks(context);
  CeilingAdjustInput input;
  input.camera = read.camera;
  input.tracks = std::move(read.tracks);
  input.map = ReadCeilingMap(context.Input("map"));
  input.trajectory = ReadTum(context.Input("trajectory"));
  if (context.HasInput("odometry")) {
    input.odometry = ReadSignals(context.Input("odometry"), SignalKind::kOdometry);
  }
  const CeilingAdjustResult result = RunCeilingAdjust(options, input, context.GetProgress());
  WriteCeiling(result.map, context);
  context.Report().update(Summarize(result));
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "ceiling_adjust",
      "Adjusts the robot's way and the landmarks of the ceiling by all pictures at once.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"tracks", "shard_NNNN.h5 of ceiling_tracks, of all shards, in order", Arity::kMany},
       {"odometry", "odometry.h5 of the frames stage", Arity::kOptional},
       {"trajectory", "trajectory.tum of ceiling_ekf"},
       {"map", "ceiling_map.h5 of ceiling_ekf"}},
      {{"trajectory", "trajectory.tum: map_from_robot at each frame; the map is its first pose"},
       {"map", "ceiling_map.h5: the filter's, with adjusted landmarks"},
       {"ply", "landmarks.ply: the landmarks, for viewers"}}};
  return StageMain(argc, argv, spec, CeilingAdjustOptions{}, Run);
}
