// SPDX-License-Identifier: Apache-2.0
// ceiling_adjust: reads tracks of corners, odometry and what the filter made of them; writes the
// adjusted trajectory and map.
#include <utility>

#include "pipeline/ceiling/ceiling_files.h"
#include "pipeline/program/stage_main.h"
#include "stages/ceiling_adjust/ceiling_adjust.h"

namespace nightmap {
namespace {

nlohmann::json Summarize(const CeilingAdjustResult& result) {
  const Vector5d& mounting = result.mounting;
  return {{"num_keyframes", result.num_keyframes},
          {"num_landmarks", result.map.landmarks.size()},
          {"num_sightings", result.num_sightings},
          {"num_motions_without_wheels", result.num_guessed_motions},
          {"num_iterations", result.solution.num_iterations},
          {"initial_cost", result.solution.initial_cost},
          {"final_cost", result.solution.final_cost},
          {"median_error_px", result.solution.median_error_px},
          {"ceiling_height_m", result.level_m},
          {"wheel_scale_error", result.wheels.x()},
          {"wheel_heading_error_rad_per_m", result.wheels.y()},
          {"mounting_rotation_rad", {mounting[0], mounting[1], mounting[2]}},
          {"mounting_translation_m", {mounting[3], mounting[4]}}};
}

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
