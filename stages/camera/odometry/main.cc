// SPDX-License-Identifier: Apache-2.0
// odometry: reads features and pairs of one shard (and the features of the shard before); writes
// poses, keyframes, edges and tracks.
#include "stages/camera/odometry/odometry.h"

#include "pipeline/geometry/bundle_report.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const OdometryOptions& options, StageContext& context) {
  OdometryInput input;
  input.frames = ReadFrames(context.Inputs("frames"));
  input.cameras = ReadCameras(context.Input("cameras"), input.frames);
  input.features = ReadFeatures(context.Inputs("features"), context.Inputs("frames"));
  input.pairs = ReadPairs(context.Input("pairs"));
  input.first_frame_idx = ReadFrames(context.Inputs("frames").back()).front().frame_idx;
  const OdometryResult result = RunOdometry(options, input, context.GetProgress());
  const OdometryShard& shard = result.shard;
  WarnOfStalls(result.adjustments);

  std::vector<StampedPose> trajectory;
  int num_keyframes = 0;
  int num_bridged = 0;
  for (const OdometryFrame& frame : shard.frames) {
    const auto position = static_cast<std::size_t>(frame.frame_idx - input.frames[0].frame_idx);
    trajectory.push_back({input.frames[position].time_ns, frame.shard_from_camera});
    num_keyframes += frame.is_keyframe;
    num_bridged += frame.state == TrackingState::kBridged;
  }
  WriteOdometry(context.Output("odometry"), shard, context.ConfigToml());
  context.WriteIfWanted("trajectory", [&] {
    return TrajectoryToTum(trajectory, "shard_from_camera, the shard's own frame of reference");
  });
  context.Report()["num_frames"] = shard.frames.size();
  context.Report()["num_keyframes"] = num_keyframes;
  context.Report()["num_bridged_frames"] = num_bridged;
  context.Report()["num_unrefined_frames"] = result.num_unrefined;
  context.Report()["bundle_adjustments"] = BundleReport(result.adjustments);
  std::size_t num_sightings = 0;
  for (const Track& track : shard.tracks) num_sightings += track.size();
  context.Report()["num_track_observations"] = num_sightings;
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "odometry",
      "Poses the frames of one shard by bundle adjustment over its feature tracks.",
      {{"frames", "shard_NNNN.csv of the previous shard (if any) and of this one", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"features", "shard_NNNN.h5 of the same shards, in order", Arity::kMany},
       {"pairs", "shard_NNNN.h5 of the matches stage"}},
      {{"odometry", "shard_NNNN.h5: poses, keyframes, edges, tracks"},
       {"trajectory", "shard_NNNN.tum: the poses in TUM format", Arity::kOptional}}};
  return StageMain(argc, argv, spec, OdometryOptions{}, Run);
}
