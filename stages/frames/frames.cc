// SPDX-License-Identifier: Apache-2.0
#include "stages/frames/frames.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

void CheckTimesIncrease(const std::vector<RawSequence>& sequences) {
  const RawSequence* previous = nullptr;
  for (const RawSequence& sequence : sequences) {
    if (sequence.frames.empty()) continue;
    if (previous && sequence.frames.front().time_ns <= previous->frames.back().time_ns) {
      throw DataError(
          "{}: starts at {} s, before the recording of {} ends at {} s: set time_offset_s so that "
          "recordings follow each other",
          sequence.name,
          TimeToString(sequence.frames.front().time_ns),
          previous->name,
          TimeToString(previous->frames.back().time_ns));
    }
    previous = &sequence;
  }
}

// Reason that keeps a frame out of the map; empty when there is none.
std::string WhyUnusable(const RawFrame& frame, const RawSequence& sequence) {
  if (!frame.problem.empty()) return frame.problem;
  return sequence.needs_depth ? frame.depth_problem : std::string();
}

// Notes the channels that a mapped frame lost. A frame that needs a lost channel is left out
// elsewhere.
void NoteLostChannels(const RawFrame& frame, std::vector<std::string>* skipped) {
  if (!frame.depth_problem.empty()) skipped->push_back(frame.depth_problem);
  skipped->insert(skipped->end(), frame.others_problems.begin(), frame.others_problems.end());
}

}  // namespace

std::size_t SelectFrames(const FramesOptions& options, std::vector<RawSequence>* sequences) {
  std::size_t num_selected = 0;
  std::size_t num_left_out = 0;
  for (RawSequence& sequence : *sequences) {
    std::vector<RawFrame> selected;
    const std::size_t stride = static_cast<std::size_t>(options.stride);
    for (std::size_t i = 0; i < sequence.frames.size(); i += stride) {
      if (options.max_frames > 0 && num_selected >= static_cast<std::size_t>(options.max_frames)) {
        ++num_left_out;
        continue;
      }
      selected.push_back(std::move(sequence.frames[i]));
      ++num_selected;
    }
    sequence.frames = std::move(selected);
  }
  return num_left_out;
}

FrameLists RunFrames(const std::vector<RawSequence>& sequences, int hold_out_every) {
  CheckTimesIncrease(sequences);
  FrameLists lists;
  std::vector<FrameWithTruth> mapping, held_out;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    for (const RawFrame& raw : sequences[s].frames) {
      ++lists.num_inspected;
      const bool is_held_out =
          hold_out_every > 0 && lists.num_inspected % static_cast<std::size_t>(hold_out_every) == 0;
      FrameWithTruth frame{raw, TruthAt(sequences[s].ground_truth, raw.time_ns)};
      frame.frame.sequence_idx = static_cast<int>(s);
      if (is_held_out) {
        if (!raw.problem.empty()) lists.skipped.push_back(raw.problem);
        held_out.push_back(std::move(frame));
      } else if (const std::string problem = WhyUnusable(raw, sequences[s]); !problem.empty()) {
        lists.skipped.push_back(problem);
        ++lists.num_frames_unusable;
      } else {
        NoteLostChannels(raw, &lists.skipped);
        mapping.push_back(std::move(frame));
      }
    }
  }
  NumberFrames(std::move(mapping), &lists.frames, &lists.ground_truth);
  NumberFrames(std::move(held_out), &lists.held_out, &lists.held_out_ground_truth);
  return lists;
}

std::vector<std::vector<FrameRecord>> CutShards(const std::vector<FrameRecord>& frames,
                                                int shard_size) {
  std::vector<std::vector<FrameRecord>> shards;
  for (const FrameRecord& frame : frames) {
    if (shards.empty() || shards.back().size() == static_cast<std::size_t>(shard_size)) {
      shards.emplace_back();
    }
    shards.back().push_back(frame);
  }
  return shards;
}

}  // namespace nightmap
