// SPDX-License-Identifier: Apache-2.0
// A video file for color and a folder of depth images, sorted by name, one per video frame. A
// frame's time is its number over the rate, and where the container's times leave that rate, the
// container's.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "pipeline/base/error.h"
#include "pipeline/io/image_io.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxFrameRate_hz = 1000;
// Periods of the rate. Containers round times to 1 ms or finer: at 200 Hz, 0.1 periods.
constexpr double kMaxJitter = 0.25;
// A recorder that stops may lose a frame or two of one of its streams.
constexpr std::size_t kMaxUnpaired = 2;
constexpr std::array<std::string_view, 4> kDepthSuffixes = {".png", ".tif", ".tiff", ".exr"};

std::vector<std::string> ListDepthFiles(const SequenceFolder& folder) {
  const fs::path path = folder.Absolute() / folder.config.depth_folder;
  if (!fs::is_directory(path)) {
    throw DataError(
        "{}: no such folder: correct `depth_folder` in {}", path.string(), folder.config.source);
  }
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(path)) {
    if (std::ranges::count(kDepthSuffixes, entry.path().extension().string()) == 0) continue;
    files.push_back(
        folder.Relative(fs::path(folder.config.depth_folder) / entry.path().filename()));
  }
  std::ranges::sort(files);
  return files;
}

bool IsFrameRate(double rate_hz) {
  return rate_hz >= kMinFrameRate_hz && rate_hz <= kMaxFrameRate_hz;
}

double FrameRate_hz(const SequenceFolder& folder, const VideoInfo& info) {
  if (folder.config.frame_rate_hz > 0) return folder.config.frame_rate_hz;
  if (IsFrameRate(info.frame_rate_hz)) return info.frame_rate_hz;
  throw DataError("{}: the video says a frame rate of {} Hz: set frame_rate_hz in {}",
                  (folder.Absolute() / folder.config.video).string(),
                  info.frame_rate_hz,
                  folder.config.source);
}

// Whether a frame is farther from where the rate puts it than rounded times are. Times that do not
// increase say nothing.
bool HasVariableRate(const VideoInfo& info) {
  const auto& times_ns = info.times_ns;
  const auto not_later = std::ranges::adjacent_find(times_ns, std::greater_equal());
  if (times_ns.size() < 2 || not_later != times_ns.end()) return false;
  if (!IsFrameRate(info.frame_rate_hz)) return true;
  const double period_ns = 1e9 / info.frame_rate_hz;
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    const double off_ns = static_cast<double>(times_ns[i]) - static_cast<double>(i) * period_ns;
    if (std::abs(off_ns) > kMaxJitter * period_ns) return true;
  }
  return false;
}

std::vector<std::int64_t> FrameTimes_ns(const SequenceFolder& folder, const VideoInfo& info) {
  if (folder.config.frame_rate_hz == 0 && HasVariableRate(info)) return info.times_ns;
  const double rate_hz = FrameRate_hz(folder, info);
  std::vector<std::int64_t> times_ns;
  for (int i = 0; i < info.num_frames; ++i) times_ns.push_back(TimeOfFrame_ns(i, rate_hz));
  return times_ns;
}

void CheckPaired(const SequenceFolder& folder, std::size_t num_depth, std::size_t num_frames) {
  const auto [fewer, more] = std::minmax(num_depth, num_frames);
  if (more - fewer <= kMaxUnpaired) return;
  throw DataError(
      "{}: {} depth images for {} video frames of {}: there must be one for each, but for up to {} "
      "at the end",
      (folder.Absolute() / folder.config.depth_folder).string(),
      num_depth,
      num_frames,
      folder.config.video,
      kMaxUnpaired);
}

}  // namespace

RawSequence ReadVideoFolder(const SequenceFolder& folder) {
  const SequenceConfig& config = folder.config;
  const VideoInfo info = InspectVideo(folder.Absolute() / config.video);
  const auto times_ns = FrameTimes_ns(folder, info);
  const bool has_depth =
      folder.NeedsDepth() || (folder.TakesDepth() && !config.depth_folder.empty());
  const auto depth = has_depth ? ListDepthFiles(folder) : std::vector<std::string>{};
  if (has_depth) CheckPaired(folder, depth.size(), times_ns.size());
  const std::string video = folder.Relative(config.video);
  RawSequence sequence;
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    RawFrame frame;
    frame.time_ns = times_ns[i];
    frame.color.path = VideoFramePath(video, static_cast<int>(i)).generic_string();
    if (has_depth && i >= depth.size()) {
      sequence.left_out.push_back(frame.color.path +
                                  ": left out, since the depth images end before it");
      continue;
    }
    if (has_depth) frame.depth.path = depth[i];
    sequence.frames.push_back(std::move(frame));
  }
  for (std::size_t i = times_ns.size(); i < depth.size(); ++i) {
    sequence.left_out.push_back(depth[i] + ": left out, since the video ends before it");
  }
  return sequence;
}

}  // namespace nightmap
