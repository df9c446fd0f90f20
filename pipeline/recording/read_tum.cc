// SPDX-License-Identifier: Apache-2.0
// TUM RGB-D layout: rgb.txt and depth.txt list `time file`, in order of time. Where one of them is
// missing, associations.txt lists pairs: `time file time file`.
#include <algorithm>
#include <cmath>
#include <functional>
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

constexpr const char* kColorList = "rgb.txt";
constexpr const char* kDepthList = "depth.txt";
constexpr const char* kAssociations = "associations.txt";

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

using Words = std::vector<std::string_view>;

bool Exists(const SequenceFolder& folder, const char* name) {
  std::error_code missing;
  return fs::exists(folder.Absolute() / name, missing);
}

// Checks a list before its lines are read, and returns the unit of its times.
TimeUnit CheckList(const SequenceFolder& folder, const char* name) {
  const fs::path path = folder.Absolute() / name;
  if (!Exists(folder, name)) {
    throw DataError(
        "{}: missing; layout \"tum\" needs it, or {}: correct `folder` or `layout` in {}",
        path.string(),
        kAssociations,
        folder.config.source);
  }
  RecordingBounds(folder).Check(folder.Relative(name));
  if (folder.config.time_unit.empty()) {
    DemandSeconds(UnitLike(path, MaxStep_s(folder)), path, folder.config.source);
  }
  return UnitOf(folder.config.time_unit);
}

ListedFile ParseFile(const SequenceFolder& folder,
                     TimeUnit unit,
                     std::string_view time,
                     std::string_view path) {
  if (path.starts_with('/') || LeadsOut(path)) {
    throw DataError("'{}' leads out of the recording's folder: give a path inside", path);
  }
  return {CheckedTime_ns(ParseTime_ns(time, unit)), folder.Relative(path)};
}

// Color pictures in the order of their list. None may be listed twice, because each is a frame
// whose name must be unique. Depth may be, because some recorders' depth is slower than color.
class ColorList {
 public:
  void Add(ListedFile file) {
    const auto [first, is_new] = first_time_.emplace(file.path, file.time_ns);
    if (!is_new) {
      throw DataError("'{}' is listed at {} s already: one picture is one frame, remove a line",
                      file.path,
                      TimeToString(first->second));
    }
    if (!files_.empty()) CheckTimeIncreases(files_.back(), file);
    files_.push_back(std::move(file));
  }
  const std::vector<ListedFile>& Files() const { return files_; }

 private:
  std::vector<ListedFile> files_;
  std::unordered_map<std::string, std::int64_t> first_time_;
};

void VisitList(const SequenceFolder& folder,
               const char* name,
               const std::function<void(ListedFile)>& visit) {
  const TimeUnit unit = CheckList(folder, name);
  VisitWordLines(folder.Absolute() / name, [&](const Words& words) {
    if (words.size() != 2) throw DataError("{} columns, expected 2 (time file)", words.size());
    visit(ParseFile(folder, unit, words[0], words[1]));
  });
}

std::vector<std::int64_t> Times(const std::vector<ListedFile>& files) {
  std::vector<std::int64_t> times;
  for (const ListedFile& file : files) times.push_back(file.time_ns);
  return times;
}

RawSequence SequenceOf(const std::vector<ListedFile>& color) {
  RawSequence sequence;
  for (const ListedFile& file : color) {
    RawFrame& frame = sequence.frames.emplace_back();
    frame.time_ns = file.time_ns;
    frame.color.path = file.path;
  }
  return sequence;
}

std::int64_t MaxGap_ns(const SequenceFolder& folder) {
  return std::llround(folder.config.max_association_gap_s * 1e9);
}

RawSequence ReadLists(const SequenceFolder& folder) {
  ColorList color;
  VisitList(folder, kColorList, [&](ListedFile file) { color.Add(std::move(file)); });
  std::vector<ListedFile> depth;
  if (folder.NeedsDepth() || (folder.TakesDepth() && Exists(folder, kDepthList))) {
    VisitList(folder, kDepthList, [&](ListedFile file) {
      if (!depth.empty()) CheckTimeIncreases(depth.back(), file);
      depth.push_back(std::move(file));
    });
  }
  RawSequence sequence = SequenceOf(color.Files());
  const auto pairs = AssociateTimes(Times(color.Files()), Times(depth), MaxGap_ns(folder));
  for (const auto& [i, j] : pairs) sequence.frames[i].depth.path = depth[j].path;
  return sequence;
}

// 1 when the first picture of a pair is depth by its path, -1 when the second is, else 0.
int DepthFirst(const Words& words) {
  const auto is_depth = [](std::string_view path) {
    return path.find("depth") == std::string_view::npos ? 0 : 1;
  };
  if (words.size() != 4) {
    throw DataError("{} columns, expected 4 (time file time file)", words.size());
  }
  return is_depth(words[1]) - is_depth(words[3]);
}

// ORB-SLAM's lists have color first, those of ICL-NUIM depth.
RawSequence ReadAssociations(const SequenceFolder& folder) {
  const TimeUnit unit = CheckList(folder, kAssociations);
  const fs::path path = folder.Absolute() / kAssociations;
  int balance = 0;
  VisitWordLines(path, [&](const Words& words) { balance += DepthFirst(words); });
  const bool depth_first = balance > 0;
  ColorList color;
  std::vector<ListedFile> depth;
  VisitWordLines(path, [&](const Words& words) {
    if (DepthFirst(words) == (depth_first ? -1 : 1)) {
      throw DataError("most lines have {} first, and this has not: swap its pictures",
                      depth_first ? "depth" : "color");
    }
    ListedFile first = ParseFile(folder, unit, words[0], words[1]);
    ListedFile second = ParseFile(folder, unit, words[2], words[3]);
    if (depth_first) std::swap(first, second);
    color.Add(std::move(first));
    depth.push_back(std::move(second));
  });
  RawSequence sequence = SequenceOf(color.Files());
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const std::int64_t gap_ns = std::abs(depth[i].time_ns - color.Files()[i].time_ns);
    if (folder.TakesDepth() && gap_ns <= MaxGap_ns(folder)) {
      sequence.frames[i].depth.path = depth[i].path;
    }
  }
  return sequence;
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
  const bool has_lists =
      Exists(folder, kColorList) && (Exists(folder, kDepthList) || !folder.NeedsDepth());
  RawSequence sequence =
      has_lists || !Exists(folder, kAssociations) ? ReadLists(folder) : ReadAssociations(folder);
  for (RawFrame& frame : sequence.frames) {
    if (!folder.NeedsDepth() || !frame.depth.path.empty()) continue;
    frame.depth_problem = fmt::format("{}: no depth image within max_association_gap_s = {}",
                                      frame.color.path,
                                      folder.config.max_association_gap_s);
  }
  return sequence;
}

}  // namespace nightmap
