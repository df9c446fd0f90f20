// SPDX-License-Identifier: Apache-2.0
#include "stages/frames/frames.h"

#include <algorithm>
#include <map>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

// A longer gap in the truth is a dropout: interpolating over it would invent the truth.
constexpr std::int64_t kMaxTruthGap_ns = 100'000'000;

std::optional<Rigid3> TruthAt(const std::vector<StampedPose>& truth, std::int64_t time_ns) {
  const auto next = std::ranges::lower_bound(truth, time_ns, {}, &StampedPose::time_ns);
  if (next == truth.end()) return std::nullopt;
  if (next->time_ns == time_ns) return next->pose;
  if (next == truth.begin()) return std::nullopt;
  const StampedPose& a = *std::prev(next);
  const StampedPose& b = *next;
  if (b.time_ns - a.time_ns > kMaxTruthGap_ns) return std::nullopt;
  const double ratio =
      static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
  return Rigid3{a.pose.rotation.slerp(ratio, b.pose.rotation),
                a.pose.translation + ratio * (b.pose.translation - a.pose.translation)};
}

void CheckTimesIncrease(const std::vector<RawSequence>& sequences) {
  const RawSequence* previous = nullptr;
  for (const RawSequence& sequence : sequences) {
    if (sequence.is_query || sequence.frames.empty()) continue;
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

// A record and its truth, before it has its index.
struct Candidate {
  FrameRecord record;
  std::optional<Rigid3> truth;
};

Candidate MakeCandidate(const RawFrame& frame, const RawSequence& sequence, int sequence_idx) {
  return {{.frame_idx = 0,
           .time_ns = frame.time_ns,
           .color_path = frame.color_path,
           .depth_path = frame.depth_problem.empty() ? frame.depth_path : "",
           .camera_idx = frame.camera_idx,
           .sequence_idx = sequence_idx,
           .content_hash = frame.content_hash},
          TruthAt(sequence.ground_truth, frame.time_ns)};
}

void Number(std::vector<Candidate> candidates,
            std::vector<FrameRecord>* frames,
            std::vector<StampedPose>* truth) {
  for (Candidate& candidate : candidates) {
    candidate.record.frame_idx = static_cast<int>(frames->size());
    if (candidate.truth) truth->push_back({candidate.record.time_ns, *candidate.truth});
    frames->push_back(std::move(candidate.record));
  }
}

void SortQueries(std::vector<Candidate>* queries) {
  const auto time = [](const Candidate& query) { return query.record.time_ns; };
  std::ranges::stable_sort(*queries, {}, time);
  const auto twin = std::ranges::adjacent_find(*queries, {}, time);
  if (twin == queries->end()) return;
  throw DataError("queries {} and {} have the same time {} s: set time_offset_s of a [[query]]",
                  twin->record.color_path,
                  std::next(twin)->record.color_path,
                  TimeToString(twin->record.time_ns));
}

}  // namespace

std::size_t SelectFrames(const FramesOptions& options, std::vector<RawSequence>* sequences) {
  std::size_t num_selected = 0;
  std::size_t num_left_out = 0;
  for (RawSequence& sequence : *sequences) {
    if (sequence.is_query) continue;
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
  std::vector<Candidate> mapping, queries;
  int num_selected = 0;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    for (const RawFrame& frame : sequences[s].frames) {
      ++lists.num_inspected;
      if (!sequences[s].is_query) ++num_selected;
      const bool held_out = hold_out_every > 0 && num_selected % hold_out_every == 0;
      const bool is_query = sequences[s].is_query || held_out;
      const std::string& problem =
          is_query || !frame.problem.empty() ? frame.problem : frame.depth_problem;
      if (!problem.empty()) lists.skipped.push_back(problem);
      if (!is_query && !problem.empty()) {
        ++lists.num_frames_unusable;
        continue;
      }
      auto& list = is_query ? queries : mapping;
      list.push_back(MakeCandidate(frame, sequences[s], static_cast<int>(s)));
    }
  }
  SortQueries(&queries);
  Number(std::move(mapping), &lists.frames, &lists.ground_truth);
  Number(std::move(queries), &lists.queries, &lists.query_ground_truth);
  return lists;
}

std::vector<RgbdCamera> KeepUsedCameras(const std::vector<RgbdCamera>& cameras,
                                        std::vector<FrameRecord>* frames) {
  std::map<int, int> kept_idx;
  for (const FrameRecord& frame : *frames) kept_idx[frame.camera_idx] = 0;
  std::vector<RgbdCamera> kept;
  for (auto& [camera_idx, idx] : kept_idx) {
    idx = static_cast<int>(kept.size());
    kept.push_back(cameras.at(static_cast<std::size_t>(camera_idx)));
  }
  for (FrameRecord& frame : *frames) frame.camera_idx = kept_idx.at(frame.camera_idx);
  return kept;
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
