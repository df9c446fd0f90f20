// SPDX-License-Identifier: Apache-2.0
// queries: the pictures to locate in a site's map: frames held out of its recordings, and the
// pictures of [[query]] tables, each with its camera and, where known, its true pose.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/recording/frame_lists.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {

struct QueriesOptions {
  double max_picture_mpx = 128;

  void Register(OptionList& list) {
    list.Add("max_picture_mpx",
             &max_picture_mpx,
             {0.01, 1000},
             "million pixels of the largest picture; decoding takes 6 bytes for each, per thread");
  }
};

struct QueryLists {
  std::vector<FrameRecord> queries;       // time_ns increases, frame_idx counts from 0
  std::vector<StampedPose> ground_truth;  // at the queries that have one
  std::vector<std::string> skipped;       // what is wrong with a picture, which stays a query
};

// The held-out frames, as the frames stage lists them, and the pictures of `sequences` in the order
// of time. A picture with a problem stays, for localize to count it as a failure; what is wrong
// with its depth is no matter, as it is located by its color. sequence_idx of the sequences counts
// from `num_recordings`, those of the site, on. Throws DataError when two queries have one time.
// Pure and deterministic.
QueryLists RunQueries(const std::vector<FrameRecord>& held_out,
                      const std::vector<StampedPose>& held_out_ground_truth,
                      const std::vector<RawSequence>& sequences,
                      std::size_t num_recordings);

}  // namespace nightmap
