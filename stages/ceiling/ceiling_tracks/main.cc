// SPDX-License-Identifier: Apache-2.0
// ceiling_tracks: reads the frames of a shard and of the shard before it, their pixels and their
// corners; writes the tracks of the corners.
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "pipeline/io/frame_reader.h"
#include "pipeline/io/site_features.h"
#include "pipeline/program/stage_main.h"
#include "stages/ceiling/ceiling_tracks/ceiling_tracks.h"
#include "stages/ceiling/ceiling_tracks/ceiling_tracks_report.h"

namespace {

using namespace nightmap;

void Run(const CeilingTracksOptions& options, StageContext& context) {
  CeilingTracksInput input;
  input.frames = ReadFrames(context.Inputs("frames"));
  input.cameras = ReadCameras(context.Input("cameras"), input.frames);
  input.features = SiteFeatures(context.Inputs("features"), context.Inputs("frames")).All();
  KeepFramesFrom(ReadFrames(context.Inputs("frames").back()).front().frame_idx, &input);
  const FrameReader reader(context.Input("data"));
  input.load = [&](const FrameRecord& frame) {
    const auto& camera = input.cameras.at(static_cast<std::size_t>(frame.camera_idx));
    return ToGray(reader.Color(frame, camera));
  };
  const CeilingTracksResult result =
      RunCeilingTracks(options, input, context.GetProgress(), context.NumThreads());
  for (const std::string& reason : result.skipped) context.Skip(reason);
  context.CheckSkipped(input.frames.size(), options.max_failed_ratio);
  WriteCornerTracks(context.Output("tracks"), result.tracks, context.ConfigToml());
  context.Report() = CeilingTracksReport(result);
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // frames are the unit of parallelism
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are ours
  const StageSpec spec{
      "ceiling_tracks",
      "Follows corners of the ceiling through the pictures of a shard.",
      {{"frames",
        "shard_NNNN.csv of the frames stage; the last one is the shard itself",
        Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"features", "shard_NNNN.h5 of the same shards, in order", Arity::kMany},
       FolderPort("data", "folder to which the paths in the frames file are relative")},
      {{"tracks", "shard_NNNN.h5: tracks from the last frame of the shard before on"}}};
  return StageMain(argc, argv, spec, CeilingTracksOptions{}, Run);
}
