// SPDX-License-Identifier: Apache-2.0
// queries: collects the pictures to locate in a site's map: frames held out of its recordings, and
// the pictures of [[query]] tables, each with its camera and, where known, its true pose.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/recording/frame_lists.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {

struct QueriesOptions {
  OPTION(double, max_picture_mpx, 128, {0.01, 1000},
         "million pixels of the largest picture; decoding takes 6 bytes per pixel and thread");
  OPTION(double, exif_focal_sigma_ratio, 0.05, {0, 1},
         "standard deviation of a focal length from EXIF, relative; 0: exact");
  OPTION(double, fov_focal_sigma_ratio, 0.15, {0, 1}, "likewise of one from horizontal_fov_deg");
  OPTION(double, unknown_fov_deg, 62, {1, 170},
         "usual field of view of a picture's longer side, where nothing is known of its lens");
  OPTION(double, unknown_focal_sigma_ratio, 0.35, {0.01, 1},
         "standard deviation of the focal length that this gives, relative");
  REGISTER_OPTIONS();
};

struct QueryLists {
  std::vector<FrameRecord> queries;       // time_ns increases, frame_idx counts from 0
  std::vector<StampedPose> ground_truth;  // of the queries that have one
  std::vector<std::string> skipped;       // problem of a picture, which stays a query
};

// The held-out frames, as the frames stage lists them, and the pictures of `sequences`, in order of
// time. A picture with a problem stays, so that localize counts it as a failure; problems of its
// depth do not matter, because only its color is used. sequence_idx of `sequences` starts at
// `num_recordings`, the number of the site's recordings. Throws DataError when two queries have the
// same time. Pure and deterministic.
QueryLists RunQueries(const std::vector<FrameRecord>& held_out,
                      const std::vector<StampedPose>& held_out_ground_truth,
                      const std::vector<RawSequence>& sequences,
                      std::size_t num_recordings);

}  // namespace nightmap
