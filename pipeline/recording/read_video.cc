// SPDX-License-Identifier: Apache-2.0
// A video file for color and a folder of depth images, sorted by name, one per video frame.
#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/io/image_io.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxFrameRate_hz = 1000;
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

double FrameRate_hz(const SequenceFolder& folder, const VideoInfo& info) {
  if (folder.config.frame_rate_hz > 0) return folder.config.frame_rate_hz;
  if (info.frame_rate_hz >= kMinFrameRate_hz && info.frame_rate_hz <= kMaxFrameRate_hz) {
    return info.frame_rate_hz;
  }
  throw DataError("{}: the video says a frame rate of {} Hz: set frame_rate_hz in {}",
                  (folder.Absolute() / folder.config.video).string(),
                  info.frame_rate_hz,
                  folder.config.source);
}

}  // namespace

RawSequence ReadVideoFolder(const SequenceFolder& folder) {
  const SequenceConfig& config = folder.config;
  const VideoInfo info = InspectVideo(folder.Absolute() / config.video);
  const double rate_hz = FrameRate_hz(folder, info);
  const bool has_depth =
      folder.NeedsDepth() || (folder.TakesDepth() && !config.depth_folder.empty());
  const auto depth = has_depth ? ListDepthFiles(folder) : std::vector<std::string>{};
  if (has_depth && depth.size() != static_cast<std::size_t>(info.num_frames)) {
    throw DataError("{}: {} depth images for {} video frames of {}: there must be one for each",
                    (folder.Absolute() / config.depth_folder).string(),
                    depth.size(),
                    info.num_frames,
                    config.video);
  }
  RawSequence sequence;
  for (int i = 0; i < info.num_frames; ++i) {
    RawFrame frame;
    frame.time_ns = TimeOfFrame_ns(i, rate_hz);
    frame.color.path = VideoFramePath(folder.Relative(config.video), i).generic_string();
    if (has_depth) frame.depth.path = depth[static_cast<std::size_t>(i)];
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace nightmap
