// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/frames/frames.h"

#include "stages/recording/frames/frame_order.h"

namespace nightmap {
namespace {

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
  for (RawSequence& sequence : *sequences) {
    std::vector<RawFrame> selected;
    const std::size_t stride = static_cast<std::size_t>(options.stride);
    for (std::size_t i = 0; i < sequence.frames.size(); i += stride) {
      selected.push_back(std::move(sequence.frames[i]));
    }
    sequence.frames = std::move(selected);
  }
  const auto order = OrderFrames(*sequences);
  const auto most = static_cast<std::size_t>(options.max_frames);
  if (most == 0 || order.size() <= most) return 0;
  std::vector<std::size_t> num_kept(sequences->size());
  for (std::size_t i = 0; i < most; ++i) ++num_kept[order[i].sequence_idx];
  for (std::size_t s = 0; s < sequences->size(); ++s) (*sequences)[s].frames.resize(num_kept[s]);
  return order.size() - most;
}

FrameLists RunFrames(const std::vector<RawSequence>& sequences, int hold_out_every) {
  CheckTimesIncrease(sequences);
  FrameLists lists;
  std::vector<FrameWithTruth> mapping, held_out;
  for (const RawSequence& sequence : sequences) {
    lists.left_out.insert(lists.left_out.end(), sequence.left_out.begin(), sequence.left_out.end());
  }
  for (const OrderedFrame& one : OrderFrames(sequences)) {
    const RawSequence& sequence = sequences[one.sequence_idx];
    const RawFrame& raw = sequence.frames[one.frame];
    ++lists.num_inspected;
    const bool is_held_out =
        hold_out_every > 0 && lists.num_inspected % static_cast<std::size_t>(hold_out_every) == 0;
    FrameWithTruth frame{raw, TruthAt(sequence.ground_truth, raw.time_ns)};
    frame.frame.time_ns = one.time_ns;
    frame.frame.sequence_idx = static_cast<int>(one.sequence_idx);
    if (is_held_out) {
      if (!raw.problem.empty()) lists.skipped.push_back(raw.problem);
      held_out.push_back(std::move(frame));
    } else if (const std::string problem = WhyUnusable(raw, sequence); !problem.empty()) {
      lists.skipped.push_back(problem);
      ++lists.num_frames_unusable;
    } else {
      NoteLostChannels(raw, &lists.skipped);
      mapping.push_back(std::move(frame));
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
