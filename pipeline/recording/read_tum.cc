// SPDX-License-Identifier: Apache-2.0
// TUM RGB-D layout: rgb.txt and depth.txt list `time file`, in order of time.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <unordered_map>

#include "pipeline/base/error.h"
#include "pipeline/io/text_file.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/recording_bounds.h"
#include "pipeline/recording/time_unit.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

struct ListedFile {
  std::int64_t time_ns;
  std::string path;
};

bool LeadsOut(std::string_view path) {
  if (path.find("..") == std::string_view::npos) return false;
  return *fs::path(path).lexically_normal().begin() == "..";
}

// Where names go on as times go back, times may be what is wrong: sorted by them, frames would be
// in another order than they were recorded in.
void CheckTimeIncreases(const ListedFile& before, const ListedFile& file) {
  if (file.time_ns > before.time_ns) return;
  const auto length = [](const ListedFile& listed) {
    return std::pair(listed.path.size(), listed.path);
  };
  throw DataError("times must increase, and this is {} after {}: {}",
                  TimeToString(file.time_ns),
                  TimeToString(before.time_ns),
                  file.time_ns == before.time_ns  ? "remove repeated times"
                  : length(file) > length(before) ? "the names of the pictures go on, so correct "
                                                    "the times, or sort the lines if they are right"
                                                  : "sort the lines by time");
}

// Depth may be listed twice, because some recorders' depth is slower than their color. A color
// picture may not, because each is a frame whose name must be unique.
std::vector<ListedFile> ReadList(const SequenceFolder& folder,
                                 const char* name,
                                 bool may_repeat_files) {
  const fs::path path = folder.Absolute() / name;
  std::error_code missing;
  if (!fs::exists(path, missing)) {
    throw DataError("{}: missing; layout \"tum\" needs it: correct `folder` or `layout` in {}",
                    path.string(),
                    folder.config.source);
  }
  RecordingBounds(folder).Check(folder.Relative(name));
  const TimeUnit unit = UnitOf(folder.config.time_unit);
  if (folder.config.time_unit.empty()) {
    DemandSeconds(UnitLike(path, MaxStep_s(folder)), path, folder.config.source);
  }
  std::vector<ListedFile> files;
  std::unordered_map<std::string, std::int64_t> first_time;
  VisitWordLines(path, [&](const std::vector<std::string_view>& words) {
    if (words.size() != 2) throw DataError("{} columns, expected 2 (time file)", words.size());
    if (words[1].starts_with('/') || LeadsOut(words[1])) {
      throw DataError("'{}' leads out of the recording's folder: give a path inside", words[1]);
    }
    files.push_back({CheckedTime_ns(ParseTime_ns(words[0], unit)), folder.Relative(words[1])});
    if (!may_repeat_files) {
      const auto [first, is_new] = first_time.emplace(files.back().path, files.back().time_ns);
      if (!is_new) {
        throw DataError("'{}' is listed at {} s already: one picture is one frame, remove a line",
                        words[1],
                        TimeToString(first->second));
      }
    }
    if (files.size() > 1) CheckTimeIncreases(files[files.size() - 2], files.back());
  });
  return files;
}

std::vector<std::int64_t> Times(const std::vector<ListedFile>& files) {
  std::vector<std::int64_t> times;
  for (const ListedFile& file : files) times.push_back(file.time_ns);
  return times;
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> AssociateTimes(const std::vector<std::int64_t>& a,
                                                                const std::vector<std::int64_t>& b,
                                                                std::int64_t max_gap_ns) {
  std::vector<std::tuple<std::int64_t, std::size_t, std::size_t>> candidates;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto first = std::ranges::lower_bound(b, a[i] - max_gap_ns);
    for (auto it = first; it != b.end() && *it <= a[i] + max_gap_ns; ++it) {
      candidates.emplace_back(std::abs(*it - a[i]), i, static_cast<std::size_t>(it - b.begin()));
    }
  }
  std::ranges::sort(candidates);
  std::vector<bool> a_used(a.size()), b_used(b.size());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [gap, i, j] : candidates) {
    if (a_used[i] || b_used[j]) continue;
    a_used[i] = b_used[j] = true;
    pairs.emplace_back(i, j);
  }
  std::ranges::sort(pairs);
  return pairs;
}

RawSequence ReadTumFolder(const SequenceFolder& folder) {
  const auto color = ReadList(folder, "rgb.txt", false);
  std::error_code missing;
  const bool has_depth =
      folder.NeedsDepth() ||
      (folder.TakesDepth() && fs::exists(folder.Absolute() / "depth.txt", missing));
  const auto depth = has_depth ? ReadList(folder, "depth.txt", true) : std::vector<ListedFile>{};
  RawSequence sequence;
  for (const ListedFile& file : color) {
    RawFrame& frame = sequence.frames.emplace_back();
    frame.time_ns = file.time_ns;
    frame.color.path = file.path;
  }
  const std::int64_t max_gap_ns = std::llround(folder.config.max_association_gap_s * 1e9);
  for (const auto& [i, j] : AssociateTimes(Times(color), Times(depth), max_gap_ns)) {
    sequence.frames[i].depth.path = depth[j].path;
  }
  for (RawFrame& frame : sequence.frames) {
    if (!folder.NeedsDepth() || !frame.depth.path.empty()) continue;
    frame.depth_problem = fmt::format("{}: no depth image within max_association_gap_s = {}",
                                      frame.color.path,
                                      folder.config.max_association_gap_s);
  }
  return sequence;
}

}  // namespace nightmap
