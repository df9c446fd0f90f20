// SPDX-License-Identifier: Apache-2.0
// odometry: reads features and pairs of one shard (and the features of the shard before); writes
// poses, keyframes, edges and tracks.
#include "stages/camera/odometry/odometry.h"

#include "pipeline/geometry/bundle_report.h"
#include "pipeline/io/site_features.h"
#include "pipeline/program/stage_main.h"
#include "stages/camera/odometry/odometry_output.h"

namespace nightmap {
namespace {

void Run(const OdometryOptions& options, StageContext& context) {
  OdometryInput input;
  input.frames = ReadFrames(context.Inputs("frames"));
  input.cameras = ReadCameras(context.Input("cameras"), input.frames);
  input.features = SiteFeatures(context.Inputs("features"), context.Inputs("frames")).All();
  input.pairs = ReadPairs(context.Input("pairs"));
  input.first_frame_idx = ReadFrames(context.Inputs("frames").back()).front().frame_idx;
  const OdometryResult result = RunOdometry(options, input, context.GetProgress());
  WarnOfStalls(result.adjustments);
  WriteOdometryResult(input, result, context);
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
