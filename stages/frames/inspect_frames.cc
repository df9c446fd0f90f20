// SPDX-License-Identifier: Apache-2.0
#include "stages/frames/inspect_frames.h"

#include <map>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/data_paths.h"
#include "pipeline/io/image_io.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

void CheckSize(const std::string& path, int width, int height, const Camera& camera) {
  if (width == camera.width && height == camera.height) return;
  throw DataError(
      "{}: {} x {} pixels, its camera has {} x {}: pictures of another size need another camera",
      path,
      width,
      height,
      camera.width,
      camera.height);
}

// A video is opened and hashed once, not for each of its frames.
struct Video {
  VideoInfo info;
  std::string hash;
};
using Videos = std::map<std::string, Video>;

Videos InspectVideos(const std::vector<RawSequence>& sequences, const fs::path& data_root) {
  Videos videos;
  for (const RawSequence& sequence : sequences) {
    if (sequence.frames.empty()) continue;
    const auto parts = SplitVideoFramePath(sequence.frames.front().color_path);
    std::error_code missing;
    if (!parts || fs::exists(data_root / sequence.frames.front().color_path, missing)) continue;
    const fs::path path = data_root / parts->first;
    videos[parts->first.generic_string()] = {InspectVideo(path), HashFile(path)};
  }
  return videos;
}

std::string InspectColor(const std::string& path,
                         const Camera& camera,
                         const fs::path& data_root,
                         const Videos& videos) {
  if (const auto parts = SplitVideoFramePath(path)) {
    const auto video = videos.find(parts->first.generic_string());
    if (video != videos.end()) {
      CheckSize(path, video->second.info.width, video->second.info.height, camera);
      return video->second.hash;
    }
  }
  const ImageInfo info = InspectImage(data_root / path);
  CheckSize(path, info.width, info.height, camera);
  return HashFile(data_root / path);
}

std::string InspectDepth(const std::string& path,
                         const RgbdCamera& camera,
                         const fs::path& data_root) {
  const ImageInfo info = InspectImage(data_root / path);
  CheckSize(path, info.width, info.height, camera.depth_registered ? camera.color : camera.depth);
  if (info.num_bits != 16 || info.num_channels != 1) {
    throw DataError("{}: depth must be one channel of 16 bits, this has {} of {}",
                    path,
                    info.num_channels,
                    info.num_bits);
  }
  return HashFile(data_root / path);
}

// Returns what is wrong with a file; empty when nothing is.
template <typename Inspect>
std::string Problem(const fs::path& data_root, const std::string& file, Inspect inspect) {
  try {
    inspect();
  } catch (const DataError& error) {
    return WithoutDataRoot(error.what(), data_root, file);
  }
  return "";
}

void InspectFrame(const RgbdCamera& camera,
                  const fs::path& data_root,
                  const Videos& videos,
                  RawFrame* frame) {
  if (frame->problem.empty()) {
    frame->problem = Problem(data_root, frame->color_path, [&] {
      frame->content_hash = InspectColor(frame->color_path, camera.color, data_root, videos);
    });
  }
  if (!frame->problem.empty()) {
    frame->content_hash = "unreadable";
    return;
  }
  if (frame->depth_path.empty() || !frame->depth_problem.empty()) return;
  frame->depth_problem = Problem(data_root, frame->depth_path, [&] {
    frame->content_hash += InspectDepth(frame->depth_path, camera, data_root);
  });
}

}  // namespace

void InspectFrames(const std::vector<RgbdCamera>& cameras,
                   const fs::path& data_root,
                   Progress& progress,
                   int num_threads,
                   std::vector<RawSequence>* sequences) {
  std::vector<std::pair<RawFrame*, const RgbdCamera*>> work;
  for (RawSequence& sequence : *sequences) {
    for (RawFrame& frame : sequence.frames) {
      work.emplace_back(&frame, &cameras.at(static_cast<std::size_t>(frame.camera_idx)));
    }
  }
  const Videos videos = InspectVideos(*sequences, data_root);
  progress.Start(work.size());
  ParallelFor(work.size(), num_threads, [&](std::size_t i) {
    InspectFrame(*work[i].second, data_root, videos, work[i].first);
    progress.Advance();
  });
}

}  // namespace nightmap
