// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/queries/queries.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

void SortByTime(std::vector<FrameWithTruth>* queries) {
  const auto time = [](const FrameWithTruth& query) { return query.frame.time_ns; };
  std::ranges::stable_sort(*queries, {}, time);
  const auto twin = std::ranges::adjacent_find(*queries, {}, time);
  if (twin == queries->end()) return;
  throw DataError("queries {} and {} have the same time {} s: set time_offset_s of a [[query]]",
                  twin->frame.color.path,
                  std::next(twin)->frame.color.path,
                  TimeToString(twin->frame.time_ns));
}

}  // namespace

QueryLists RunQueries(const std::vector<FrameRecord>& held_out,
                      const std::vector<StampedPose>& held_out_ground_truth,
                      const std::vector<RawSequence>& sequences,
                      std::size_t num_recordings) {
  QueryLists lists;
  std::vector<FrameWithTruth> queries;
  for (const FrameRecord& frame : held_out) {
    const int pose = FindPose(held_out_ground_truth, frame.time_ns);
    queries.push_back({frame, {}});
    if (pose >= 0) {
      queries.back().truth = held_out_ground_truth[static_cast<std::size_t>(pose)].pose;
    }
  }
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    lists.skipped.insert(
        lists.skipped.end(), sequences[s].left_out.begin(), sequences[s].left_out.end());
    for (const RawFrame& raw : sequences[s].frames) {
      if (!raw.problem.empty()) lists.skipped.push_back(raw.problem);
      queries.push_back({raw, TruthAt(sequences[s].ground_truth, raw.time_ns)});
      queries.back().frame.sequence_idx = static_cast<int>(num_recordings + s);
    }
  }
  SortByTime(&queries);
  NumberFrames(std::move(queries), &lists.queries, &lists.ground_truth);
  return lists;
}

}  // namespace nightmap
