// SPDX-License-Identifier: Apache-2.0
// inspect: summarizes each channel of a recording before any other stage runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/read_signals.h"
#include "stages/recording/inspect/sampled_pictures.h"

namespace nightmap {

struct InspectOptions {
  OPTION(int, num_sampled_frames, 20, {1, 1e6}, "frames per recording whose pictures are examined");
  OPTION(double, max_failed_ratio, 1, {0, 1}, "fails when a larger share of the lines is unusable");
  REGISTER_OPTIONS();
};

// The times of one channel and a summary of its values.
struct ChannelSeries {
  std::string source;   // of frames: recording and its number; of signals: the sensor's id
  std::string channel;  // color, depth, label ..., ground truth, acceleration, odometry, scan
  std::size_t count = 0;
  double rate_hz = 0;        // from the median interval; 0 with fewer than two samples
  double largest_gap_s = 0;  // between successive samples
  std::size_t num_gaps = 0;  // number of intervals longer than three medians
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  std::string details;  // sizes, ranges, units
};

// Times ascend.
ChannelSeries DescribeTimes(std::string source,
                            std::string channel,
                            const std::vector<std::int64_t>& times_ns);

// Looks at some frames of a recording.
using PictureSampler = std::function<SampledPictures(const RawSequence&)>;

// The channels of recordings and signals, in the order of the site config. The sampled frames of
// each recording tell the size of their pictures and the range of their depth. Counts unreadable
// ones in the details. Deterministic.
std::vector<ChannelSeries> RunInspect(const std::vector<RawSequence>& sequences,
                                      const std::vector<Signal>& signals,
                                      const PictureSampler& sample);

// The series as a table, and the time span that each signal shares with each recording.
std::string InspectionText(const std::vector<ChannelSeries>& series);

}  // namespace nightmap
