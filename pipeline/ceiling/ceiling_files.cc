// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/ceiling_files.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/ceiling/join_tracks.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

constexpr double kSamePixel_px = 1;  // of one corner, tracked in one shard and found in the next

}  // namespace

RgbdCamera OneCamera(const std::vector<FrameRecord>& frames,
                     const std::vector<RgbdCamera>& cameras) {
  const FrameRecord& first = frames.front();
  const bool is_one = std::ranges::all_of(frames, [&](const FrameRecord& frame) {
    return frame.camera_idx == first.camera_idx && frame.sequence_idx == first.sequence_idx;
  });
  if (!is_one) {
    throw InputError({{"frames"}},
                     InputError::Remedy::kInText,
                     "the frames are of several cameras or recordings; the profile ceiling maps "
                     "one [[sequence]] of one upward camera: make a site of each");
  }
  return cameras.at(static_cast<std::size_t>(first.camera_idx));
}

CeilingTracks ReadCeilingTracks(StageContext& context) {
  const std::vector<FrameRecord> frames = ReadFrames(context.Inputs("frames"));
  CeilingTracks read;
  read.camera = OneCamera(frames, ReadCameras(context.Input("cameras"), frames));
  std::vector<CornerTracks> shards;
  for (const auto& path : context.Inputs("tracks")) shards.push_back(ReadCornerTracks(path));
  read.tracks = JoinTracks(std::move(shards), kSamePixel_px);
  return read;
}

void WriteCeiling(const CeilingMap& map, StageContext& context) {
  std::vector<StampedPose> poses;
  for (const CeilingFrame& frame : map.frames) {
    poses.push_back({frame.time_ns, frame.map_from_robot.ToRigid3()});
  }
  WriteFile(context.Output("trajectory"), TrajectoryToTum(poses, "map_from_robot at each frame"));
  WriteCeilingMap(context.Output("map"), map, context.ConfigToml());
  WriteFile(context.Output("ply"), LandmarksToPly(map.landmarks));
}

}  // namespace nightmap
