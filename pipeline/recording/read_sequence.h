// SPDX-License-Identifier: Apache-2.0
// Lists the pictures of a recording in each supported folder layout.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/io/site_config.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {

// One frame of a recording, as listed there, before its files were looked at: what is wrong with
// it, beside what is listed. Hashes are filled by InspectFrames.
struct RawFrame : FrameRecord {
  std::string problem;                       // why its color cannot be used; empty when it can
  std::string depth_problem;                 // why its depth cannot; a query does without
  std::vector<std::string> others_problems;  // of its other channels, which it then lacks
};

// One recording: what its folder says.
struct RawSequence {
  std::string name;  // for messages: where the site config describes it
  bool is_query = false;
  bool needs_depth = true;                // a frame without it cannot be mapped
  std::vector<RawFrame> frames;           // times increase
  std::vector<StampedPose> ground_truth;  // world_from_camera, times increase; may be empty
};

// Lists, associates and times the pictures; reads no pixels (a video is gone through once to count
// its frames). Pictures that lack their depth carry a `depth_problem` where it is required, which
// it never is of queries. A label picture is the PNG of the color picture's stem in `label_folder`,
// where there is one. A picture whose name is not text carries a `problem`, and the name as AsText
// writes it. Picture N of layout "pictures" is at N seconds. Throws DataError naming folder or file
// and line, and the remedy; also when a file lies outside of the recording (recording_bounds.h).
RawSequence ReadSequence(const SiteConfig& site,
                         const SequenceConfig& config,
                         bool is_query,
                         const std::filesystem::path& data_root);

// The recordings to map, in the order of the site config. Throws DataError also when a picture is a
// frame twice.
std::vector<RawSequence> ReadSequences(const SiteConfig& site,
                                       const std::filesystem::path& data_root);

// The recordings of the [[query]] tables. The pictures of [[query]] Q, which have no times, and
// their truth are moved to 4e9 + Q * 1e6 s, later than any clock and apart from each other whatever
// the other tables hold. Throws DataError also when a picture is a query twice.
std::vector<RawSequence> ReadQuerySequences(const SiteConfig& site,
                                            const std::filesystem::path& data_root);

// Pairs each time of `a` with at most one of `b` and the reverse, nearest pairs first, no pair
// farther apart than `max_gap_ns`. Both sorted. Returns (index in a, index in b), ascending in a.
std::vector<std::pair<std::size_t, std::size_t>> AssociateTimes(const std::vector<std::int64_t>& a,
                                                                const std::vector<std::int64_t>& b,
                                                                std::int64_t max_gap_ns);

// What the layouts share: where a recording is and what its messages name.
struct SequenceFolder {
  std::filesystem::path data_root;
  std::filesystem::path folder;  // relative to data_root
  const SequenceConfig& config;
  bool is_query;

  bool TakesDepth() const { return config.depth != "none"; }
  bool NeedsDepth() const { return !is_query && config.depth == "required"; }
  std::filesystem::path Absolute() const { return (data_root / folder).lexically_normal(); }
  // Path of a file of the recording relative to the data folder, normalized.
  std::string Relative(const std::filesystem::path& file) const {
    return (folder / file).lexically_normal().generic_string();
  }
};

// A time so near to 0 (146 years) that differences and offsets of times fit 64 bits. Throws
// DataError.
std::int64_t CheckedTime_ns(std::int64_t time_ns);
// The time of frame `number` of a recording without times, from 0. Throws DataError when it is out
// of range.
std::int64_t TimeOfFrame_ns(std::int64_t number, double frame_rate_hz);

// Times do not yet include time_offset_s.
RawSequence ReadTumFolder(const SequenceFolder& folder);
RawSequence ReadSevenScenesFolder(const SequenceFolder& folder);
RawSequence ReadVideoFolder(const SequenceFolder& folder);
RawSequence ReadPictures(const SequenceFolder& folder);

// Where the pictures of layout "pictures" and their cameras.csv lie, relative to the data folder.
std::string PicturesFolder(const SequenceFolder& folder);

}  // namespace nightmap
