// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/odometry/odometry_output.h"

#include <algorithm>

#include "pipeline/geometry/bundle_report.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

std::vector<StampedPose> TrajectoryOf(const OdometryInput& input, const OdometryShard& shard) {
  std::vector<StampedPose> trajectory;
  for (const OdometryFrame& frame : shard.frames) {
    const auto position = static_cast<std::size_t>(frame.frame_idx - input.frames[0].frame_idx);
    trajectory.push_back({input.frames[position].time_ns, frame.shard_from_camera});
  }
  return trajectory;
}

nlohmann::json Summarize(const OdometryResult& result) {
  const OdometryShard& shard = result.shard;
  std::size_t num_sightings = 0;
  for (const Track& track : shard.tracks) num_sightings += track.size();
  return {{"num_frames", shard.frames.size()},
          {"num_keyframes", std::ranges::count_if(shard.frames, &OdometryFrame::is_keyframe)},
          {"num_bridged_frames",
           std::ranges::count(shard.frames, TrackingState::kBridged, &OdometryFrame::state)},
          {"num_unrefined_frames", result.num_unrefined},
          {"bundle_adjustments", BundleReport(result.adjustments)},
          {"num_track_observations", num_sightings}};
}

}  // namespace

void WriteOdometryResult(const OdometryInput& input,
                         const OdometryResult& result,
                         StageContext& context) {
  WriteOdometry(context.Output("odometry"), result.shard, context.ConfigToml());
  context.WriteIfWanted("trajectory", [&] {
    return TrajectoryToTum(TrajectoryOf(input, result.shard),
                           "shard_from_camera, the shard's own frame of reference");
  });
  context.Report().update(Summarize(result));
}

}  // namespace nightmap
