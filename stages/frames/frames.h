// SPDX-License-Identifier: Apache-2.0
// frames: turns a site's recordings into one list of RGB-D frames, cut into shards, with held-out
// and extra pictures as queries and the ground truth at the frames' times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

struct FramesOptions {
  int shard_size = 200;
  int stride = 1;
  int max_frames = 0;
  double max_failed_ratio = 0.2;
  double max_picture_mpx = 128;

  void Register(OptionList& list) {
    list.Add("shard_size", &shard_size, {1, 1e6}, "frames in one shard, the unit of parallel work");
    list.Add("stride", &stride, {1, 1e6}, "use every Nth frame of a recording");
    list.Add("max_frames", &max_frames, {0, 1e9}, "use at most this many frames; 0: all");
    list.Add("max_failed_ratio", &max_failed_ratio, {0, 1}, "fail when more frames are unusable");
    list.Add("max_picture_mpx",
             &max_picture_mpx,
             {0.01, 1000},
             "million pixels of the largest picture; decoding takes 6 bytes for each, per thread");
  }
};

// One picture of a recording, as listed there, before its files were looked at.
struct RawFrame {
  std::int64_t time_ns = 0;   // time_offset_s included
  std::string color_path;     // relative to the data folder
  std::string depth_path;     // may be empty for a query
  std::string problem;        // why its color cannot be used; empty when it can
  std::string depth_problem;  // why its depth cannot; a query does without
  std::string content_hash;   // filled by InspectFrames
  int camera_idx = 0;         // into the site's cameras and those found after them
};

// One recording: what its folder says.
struct RawSequence {
  std::string name;  // for messages: where the site config describes it
  bool is_query = false;
  std::vector<RawFrame> frames;           // times increase
  std::vector<StampedPose> ground_truth;  // world_from_camera, times increase; may be empty
};

// Removes what stride and max_frames leave out. Queries of their own folders are not thinned.
// Returns the number of frames that max_frames alone left out: the last ones.
[[nodiscard]] std::size_t SelectFrames(const FramesOptions& options,
                                       std::vector<RawSequence>* sequences);

struct FrameLists {
  std::vector<FrameRecord> frames;              // time_ns increases, frame_idx counts from 0
  std::vector<FrameRecord> queries;             // the same, frame_idx counting from 0 on its own
  std::vector<StampedPose> ground_truth;        // at the frames that have one
  std::vector<StampedPose> query_ground_truth;  // at the queries that have one
  std::vector<std::string> skipped;             // one reason a frame with a problem
  std::size_t num_inspected = 0;
  std::size_t num_frames_unusable = 0;  // mapping frames left out for a problem
};

// Splits the sequences' frames into mapping frames and queries: with hold_out_every = N > 0 every
// Nth selected frame of the mapping sequences is a query. The choice depends on a frame's place in
// the lists alone, so that a damaged file moves no other frame between the two. A mapping frame
// with a problem is left out; a query with one stays, for localize to count it as a failure. What
// is wrong with the depth of a query is no matter: it is located by its color, and its depth_path
// is left empty. Truth at a frame's time is the pose of exactly that time or interpolated between
// neighbours at most 0.1 s apart (rotation by slerp). Throws DataError when sequences overlap in
// time, or two queries have one time. Pure and deterministic.
FrameLists RunFrames(const std::vector<RawSequence>& sequences, int hold_out_every);

// The cameras that the frames have, in their order among `cameras`; makes the frames' camera_idx
// count in them. So a camera that only queries have stays out of what the map is made of.
std::vector<RgbdCamera> KeepUsedCameras(const std::vector<RgbdCamera>& cameras,
                                        std::vector<FrameRecord>* frames);

// The frames cut into runs of `shard_size`; the last may be shorter.
std::vector<std::vector<FrameRecord>> CutShards(const std::vector<FrameRecord>& frames,
                                                int shard_size);

}  // namespace nightmap
