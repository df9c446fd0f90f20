// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/read_sequence.h"

#include <cmath>
#include <limits>
#include <unordered_map>

#include "pipeline/base/error.h"
#include "pipeline/base/plain_text.h"
#include "pipeline/io/text_file.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/layouts.h"
#include "pipeline/recording/recording_bounds.h"
#include "pipeline/recording/time_unit.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kPicturesStart_ns = 4'000'000'000 * kSecond_ns;
constexpr std::int64_t kPicturesPeriod_ns = 1'000'000 * kSecond_ns;

std::int64_t Offset_ns(const SequenceConfig& config) {
  return std::llround(config.time_offset_s * 1e9);
}

fs::path SitePath(const SiteConfig& site, const std::string& path, const fs::path& data_root) {
  return data_root / site.root / path;
}

void CheckFolder(const SequenceFolder& folder) {
  std::error_code ignored;
  if (fs::is_directory(folder.Absolute(), ignored)) return;
  throw DataError("{}: no such folder: correct `root` or `folder` in {}, or the data folder",
                  folder.Absolute().string(),
                  folder.config.source);
}

// The frames' list was read first: its times are in the unit that is stated.
std::vector<StampedPose> ReadTruth(const SequenceFolder& folder, const fs::path& path) {
  const SequenceConfig& config = folder.config;
  if (config.time_unit.empty()) {
    const std::string unit_like = UnitLike(path, MaxStep_s(folder));
    if (LayoutOf(config.layout).lists_times && !unit_like.empty()) {
      throw DataError(
          "{}: its times look like {}, and those of the pictures are in seconds: write them in "
          "seconds, correct `ground_truth`, or write time_unit = \"s\" if they are seconds, in {}",
          path.string(),
          unit_like,
          config.source);
    }
    DemandSeconds(unit_like, path, config.source);
  }
  return ReadTum(path, UnitOf(config.time_unit));
}

void MoveTimes(std::int64_t offset_ns, RawSequence* sequence) {
  const auto move = [&](std::int64_t* time_ns) {
    if (!__builtin_add_overflow(*time_ns, offset_ns, time_ns)) return;
    throw DataError("{}: times are out of range: name fewer [[query]]", sequence->name);
  };
  for (RawFrame& frame : sequence->frames) move(&frame.time_ns);
  for (StampedPose& pose : sequence->ground_truth) move(&pose.time_ns);
}

void AddOffset(const SequenceConfig& config, RawSequence* sequence) {
  const auto add = [&](std::int64_t* time_ns) {
    *time_ns = CheckedTime_ns(CheckedTime_ns(*time_ns) + Offset_ns(config));
  };
  try {
    for (RawFrame& frame : sequence->frames) add(&frame.time_ns);
    for (StampedPose& pose : sequence->ground_truth) add(&pose.time_ns);
  } catch (const DataError& error) {
    throw DataError("{}: {}, with its time_offset_s", config.source, error.what());
  }
}

void CheckName(std::string* path, std::string* problem) {
  if (IsText(*path)) return;
  *path = AsText(*path);
  if (!problem->empty()) return;
  *problem = *path + ": the name is not UTF-8 or holds control characters: rename the file";
}

void CheckFiles(const SequenceFolder& folder, RawSequence* sequence) {
  RecordingBounds bounds(folder);
  for (RawFrame& frame : sequence->frames) {
    CheckName(&frame.color.path, &frame.problem);
    CheckName(&frame.depth.path, &frame.depth_problem);
    if (!LayoutOf(folder.config.layout).is_recording) continue;  // may lie anywhere
    bounds.Check(frame.color.path);
    if (!frame.depth.path.empty()) bounds.Check(frame.depth.path);
    for (const auto& [name, file] : frame.others) bounds.Check(file.path);
  }
}

void CheckPictureFolder(const SequenceFolder& folder,
                        const fs::path& pictures,
                        const std::string& key) {
  std::error_code ignored;
  if (fs::is_directory(folder.Absolute() / pictures, ignored)) return;
  throw DataError("{}: no such folder: correct `{}` in {}",
                  (folder.Absolute() / pictures).string(),
                  key,
                  folder.config.source);
}

// Adds the pictures of a folder that `key` names: PNGs with the color pictures' stems, where they
// exist.
void AddChannel(const SequenceFolder& folder,
                const fs::path& pictures,
                const std::string& key,
                const std::string& channel,
                RawSequence* sequence) {
  if (pictures.empty()) return;
  CheckPictureFolder(folder, pictures, key);
  std::error_code ignored;
  for (RawFrame& frame : sequence->frames) {
    const fs::path name = pictures / (fs::path(frame.color.path).stem().string() + ".png");
    if (!fs::exists(folder.Absolute() / name, ignored)) continue;
    frame.others[channel].path = folder.Relative(name);
  }
}

// Adds the picture of its confidence to each depth picture, whether it is there or not: depth whose
// confidence is missing is not used.
void AddConfidence(const SequenceFolder& folder, RawSequence* sequence) {
  const fs::path pictures = folder.config.confidence_folder;
  if (pictures.empty()) return;
  CheckPictureFolder(folder, pictures, "confidence_folder");
  for (RawFrame& frame : sequence->frames) {
    if (frame.depth.path.empty()) continue;
    const fs::path name = pictures / (fs::path(frame.depth.path).stem().string() + ".png");
    frame.others[kConfidenceChannel].path = folder.Relative(name);
  }
}

// Two frames or queries with the same picture could not be told apart by its name.
void CheckListedOnce(const RawSequence& sequence,
                     std::unordered_map<std::string, std::string>* listed_in) {
  for (const RawFrame& frame : sequence.frames) {
    const auto [first, is_new] = listed_in->emplace(frame.color.path, sequence.name);
    if (is_new) continue;
    throw DataError("{}: {} is a {} already, of {}: leave it out of one of them",
                    sequence.name,
                    frame.color.path,
                    sequence.is_query ? "query" : "frame",
                    first->second);
  }
}

}  // namespace

std::int64_t CheckedTime_ns(std::int64_t time_ns) {
  if (time_ns >= -kMaxTime_ns && time_ns <= kMaxTime_ns) return time_ns;
  throw DataError("time {} s is out of range: it must be within 4.6e9 s of 0",
                  TimeToString(time_ns));
}

double MaxStep_s(const SequenceFolder& folder) {
  return folder.is_query ? std::numeric_limits<double>::infinity() : kMaxFrameStep_s;
}

std::int64_t TimeOfFrame_ns(std::int64_t number, double frame_rate_hz) {
  const double time_ns = static_cast<double>(number) * 1e9 / frame_rate_hz;
  if (time_ns <= static_cast<double>(kMaxTime_ns)) return std::llround(time_ns);
  throw DataError(
      "frame {} would be at {:.3g} s: correct its number or frame_rate_hz", number, time_ns / 1e9);
}

RawSequence ReadSequence(const SiteConfig& site,
                         const SequenceConfig& config,
                         bool is_query,
                         const fs::path& data_root) {
  const SequenceFolder folder{data_root, fs::path(site.root) / config.folder, config, is_query};
  CheckFolder(folder);
  RawSequence sequence = LayoutOf(config.layout).read(folder);
  if (sequence.frames.empty()) {
    throw DataError("{}: no pictures in layout \"{}\": correct `folder` or `layout` in {}",
                    folder.Absolute().string(),
                    config.layout,
                    config.source);
  }
  sequence.name = config.source;
  for (RawFrame& frame : sequence.frames) frame.camera_idx = config.camera_idx;
  sequence.is_query = is_query;
  sequence.needs_depth = folder.NeedsDepth();
  sequence.rig = config.rig;
  AddChannel(folder, config.label_folder, "label_folder", kLabelChannel, &sequence);
  AddChannel(folder, config.moving_folder, "moving_folder", kMovingChannel, &sequence);
  AddConfidence(folder, &sequence);
  if (!config.ground_truth.empty()) {
    sequence.ground_truth = ReadTruth(folder, SitePath(site, config.ground_truth, data_root));
    sequence.ground_truth_file =
        (fs::path(site.root) / config.ground_truth).lexically_normal().generic_string();
  }
  AddOffset(config, &sequence);
  CheckFiles(folder, &sequence);
  return sequence;
}

std::vector<RawSequence> ReadSequences(const SiteConfig& site, const fs::path& data_root) {
  std::vector<RawSequence> sequences;
  std::unordered_map<std::string, std::string> frame_of;  // picture -> where it is listed
  for (const SequenceConfig& config : site.sequences) {
    sequences.push_back(ReadSequence(site, config, false, data_root));
    CheckListedOnce(sequences.back(), &frame_of);
  }
  return sequences;
}

std::vector<RawSequence> ReadQuerySequences(const SiteConfig& site, const fs::path& data_root) {
  std::vector<RawSequence> sequences;
  std::unordered_map<std::string, std::string> query_of;
  std::int64_t pictures_start_ns = kPicturesStart_ns;
  for (const SequenceConfig& config : site.queries) {
    sequences.push_back(ReadSequence(site, config, true, data_root));
    if (!LayoutOf(config.layout).is_recording) MoveTimes(pictures_start_ns, &sequences.back());
    CheckListedOnce(sequences.back(), &query_of);
    pictures_start_ns += kPicturesPeriod_ns;
  }
  return sequences;
}

}  // namespace nightmap
