// SPDX-License-Identifier: Apache-2.0
// Lists the pictures of a recording in each supported folder layout.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/site_config.h"

namespace nightmap {

// One frame of a recording as listed there, before its files are checked, with the problems of the
// listing. InspectFrames fills the hashes.
struct RawFrame : FrameRecord {
  std::string problem;        // why its color cannot be used; empty when it can
  std::string depth_problem;  // why its depth cannot be used; a query does not need it
  std::vector<std::string> others_problems;  // problems of its other channels, which it then lacks
};

// One recording, as its folder describes it.
struct RawSequence {
  std::string name;  // for messages: where the site config describes it
  bool is_query = false;
  bool needs_depth = true;                // a frame without it cannot be mapped
  std::string rig;                        // sequences of one rig record at once; empty: none
  std::vector<RawFrame> frames;           // times increase
  std::vector<StampedPose> ground_truth;  // world_from_camera, times increase; may be empty
  std::string ground_truth_file;          // relative to the data folder; empty: none
  std::vector<std::string> left_out;  // files at the end that belong to no frame, with the reason
};

// Lists, associates and times the pictures without reading pixels (except that it reads through a
// video once to count its frames). A picture without depth gets a `depth_problem` where depth is
// required; for queries it never is. A picture of `label_folder` or `moving_folder` is the PNG
// with the color picture's stem, if it exists; one of `confidence_folder` is the PNG with the depth
// picture's stem, whether it exists or not. A picture whose name is not text gets a `problem`,
// and the name as AsText writes it. Picture N of layout "pictures" is at N seconds. Throws
// DataError naming folder or file and line, and the remedy; also when a file lies outside the
// recording (recording_bounds.h).
RawSequence ReadSequence(const SiteConfig& site,
                         const SequenceConfig& config,
                         bool is_query,
                         const std::filesystem::path& data_root);

// The recordings to map, in the order of the site config. Also throws DataError when a picture is a
// frame twice.
std::vector<RawSequence> ReadSequences(const SiteConfig& site,
                                       const std::filesystem::path& data_root);

// The recordings of the [[query]] tables. Pictures of [[query]] Q have no times, so they and their
// truth are moved to 4e9 + Q * 1e6 s: later than any clock, and separate whatever the other tables
// hold. Also throws DataError when a picture is a query twice.
std::vector<RawSequence> ReadQuerySequences(const SiteConfig& site,
                                            const std::filesystem::path& data_root);

// Pairs each time of `a` with at most one of `b` and vice versa, nearest pairs first, none farther
// apart than `max_gap_ns`. Both are sorted. Returns (index in a, index in b), ascending in a.
std::vector<std::pair<std::size_t, std::size_t>> AssociateTimes(const std::vector<std::int64_t>& a,
                                                                const std::vector<std::int64_t>& b,
                                                                std::int64_t max_gap_ns);

// Common to all layouts: where a recording is, and its name in messages.
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

// Checks that a time is within 146 years of 0, so that differences and offsets of times fit 64
// bits. Throws DataError.
constexpr std::int64_t kMaxTime_ns = std::int64_t{1} << 62;
std::int64_t CheckedTime_ns(std::int64_t time_ns);
// Longest median step of times in seconds without a time_unit. Queries may be of any times.
double MaxStep_s(const SequenceFolder& folder);
// Time of frame `number` (from 0) of a recording without times. Throws DataError when it is out of
// range.
std::int64_t TimeOfFrame_ns(std::int64_t number, double frame_rate_hz);

// Times do not yet include time_offset_s.
RawSequence ReadTumFolder(const SequenceFolder& folder);
RawSequence ReadSevenScenesFolder(const SequenceFolder& folder);
RawSequence ReadVideoFolder(const SequenceFolder& folder);
RawSequence ReadPictures(const SequenceFolder& folder);

// Folder, relative to the data folder, that holds the pictures of layout "pictures" and their
// cameras.csv.
std::string PicturesFolder(const SequenceFolder& folder);

}  // namespace nightmap
