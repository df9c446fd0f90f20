// SPDX-License-Identifier: Apache-2.0
// frames: turns a site's recordings into a list of mapping frames, cut into shards, and a list of
// held-out frames; both with the ground truth at their times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/recording/frame_lists.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {

struct FramesOptions {
  OPTION(int, shard_size, 200, {1, 1e6}, "frames per shard, the unit of parallel work");
  OPTION(int, stride, 1, {1, 1e6}, "uses every Nth frame of a recording");
  OPTION(int, max_frames, 0, {0, 1e9}, "uses at most this many frames; 0: all");
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the frames is unusable");
  OPTION(double, max_picture_mpx, 128, {0.01, 1000},
         "million pixels of the largest picture; decoding takes 6 bytes per pixel and thread");
  REGISTER_OPTIONS();
};

// Removes the frames that stride and max_frames leave out. Returns how many frames max_frames alone
// left out; these are the last ones.
[[nodiscard]] std::size_t SelectFrames(const FramesOptions& options,
                                       std::vector<RawSequence>* sequences);

struct FrameLists {
  std::vector<FrameRecord> frames;                 // time_ns increases, frame_idx counts from 0
  std::vector<FrameRecord> held_out;               // likewise, with a count of its own
  std::vector<StampedPose> ground_truth;           // of the frames that have one
  std::vector<StampedPose> held_out_ground_truth;  // of the held-out frames that have one
  std::vector<std::string> skipped;                // one reason per frame or channel with a problem
  std::vector<std::string> left_out;               // of all sequences
  std::size_t num_inspected = 0;
  std::size_t num_frames_unusable = 0;  // mapping frames left out because of a problem
};

// Splits the sequences' frames into mapping frames and held-out frames. Held-out frames are
// pictures to locate in the map made of the others: every Nth selected frame for hold_out_every = N
// > 0. The choice depends only on a frame's place in the lists, so a damaged file moves no other
// frame from one list to the other. A mapping frame with a problem, or without the depth that its
// sequence needs, is left out. A held-out frame with a problem stays, so that localize counts it as
// a failure. Order and times are those of OrderFrames (frame_order.h). Ground truth is interpolated
// by TruthAt at the times of the recording. Throws what CheckTimesIncrease throws. Pure and
// deterministic.
FrameLists RunFrames(const std::vector<RawSequence>& sequences, int hold_out_every);

// Cuts the frames into runs of `shard_size`; the last may be shorter.
std::vector<std::vector<FrameRecord>> CutShards(const std::vector<FrameRecord>& frames,
                                                int shard_size);

}  // namespace nightmap
