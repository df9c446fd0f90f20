// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/inspect_frames.h"

#include <map>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/camera_images.h"
#include "pipeline/io/data_paths.h"
#include "pipeline/io/image_io.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr char kOtherColor[] = "pictures of another size need another camera";
constexpr char kOtherDepth[] = "correct depth_width and depth_height of its [[camera]]";
constexpr char kUnregisteredDepth[] =
    "depth of another size than color is not registered to it: give its [[camera]] "
    "depth_registered = false with depth_width, depth_height, depth_fx, depth_fy, depth_cx, "
    "depth_cy and color_from_depth";

void CheckSize(
    const std::string& path, int width, int height, const Camera& camera, const char* remedy) {
  if (width == camera.width && height == camera.height) return;
  throw DataError("{}: {} x {} pixels, its camera has {} x {}: {}",
                  path,
                  width,
                  height,
                  camera.width,
                  camera.height,
                  remedy);
}

FileFacts FactsOf(const fs::path& path, const ImageInfo& info) {
  return {HashFile(path), info.width, info.height, info.num_channels, info.num_bits, info.is_float};
}

FileFacts ReadPictureFacts(const fs::path& path) { return FactsOf(path, InspectImage(path)); }

FileFacts ReadLabelFacts(const fs::path& path) { return FactsOf(path, InspectLabelImage(path)); }

FileFacts ReadVideoFacts(const fs::path& path) {
  const VideoInfo info = InspectVideo(path);
  return {HashFile(path), info.width, info.height, 3, 8};
}

// `kind`: what another program may have made.
void CheckIsOneByte(const std::string& path, const FileFacts& facts, const char* kind) {
  if (facts.num_bits == 8 && facts.num_channels == 1) return;
  throw DataError("{}: {} must be one channel of 8 bits, this has {} of {}",
                  path,
                  kind,
                  facts.num_channels,
                  facts.num_bits);
}

void CheckLabel(const std::string& path, const FileFacts& facts, const Camera& camera) {
  CheckSize(path, facts.width, facts.height, camera, kOtherColor);
  CheckIsOneByte(path, facts, "labels");
}

void CheckConfidence(const std::string& path, const FileFacts& facts, const RgbdCamera& camera) {
  CheckConfidenceSize(path, facts.width, facts.height, camera.DepthPicture());
  CheckIsOneByte(path, facts, "confidence");
}

void CheckDepth(const std::string& path, const FileFacts& facts, const RgbdCamera& camera) {
  const bool is_registered = camera.depth_registered;
  CheckSize(path,
            facts.width,
            facts.height,
            camera.DepthPicture(),
            is_registered ? kUnregisteredDepth : kOtherDepth);
  if (facts.num_channels != 1 || !(facts.is_float || facts.num_bits == 16)) {
    throw DataError("{}: depth must be one channel of 16 bits or of floats, this has {} of {}",
                    path,
                    facts.num_channels,
                    facts.num_bits);
  }
  if (facts.is_float || camera.depth_units_per_m > 0) return;
  throw DataError("{}: depth of integers needs depth_units_per_m in its [[camera]]", path);
}

// Returns the problem of a file; empty when there is none.
template <typename Inspect>
std::string Problem(const fs::path& data_root, const std::string& file, Inspect inspect) {
  try {
    inspect();
  } catch (const DataError& error) {
    return WithoutDataRoot(error.what(), data_root, file);
  }
  return "";
}

// Facts of videos: each is opened and hashed once, not once per frame.
using Videos = std::map<std::string, FileFacts>;

Videos InspectVideos(const std::vector<RawSequence>& sequences,
                     const fs::path& data_root,
                     HashCache& files) {
  Videos videos;
  for (const RawSequence& sequence : sequences) {
    if (sequence.frames.empty()) continue;
    const std::string& first = sequence.frames.front().color.path;
    const auto parts = SplitVideoFramePath(first);
    std::error_code missing;
    if (!parts || fs::exists(data_root / first, missing)) continue;
    const std::string video = parts->first.generic_string();
    videos[video] = files.Get(video, ReadVideoFacts);
  }
  return videos;
}

class FrameInspector {
 public:
  FrameInspector(const fs::path& data_root, const Videos& videos, HashCache& files)
      : data_root_(data_root), videos_(videos), files_(files) {}

  void Inspect(const RgbdCamera& camera, RawFrame* frame) const {
    if (frame->problem.empty()) {
      frame->problem = Problem(data_root_, frame->color.path, [&] {
        const FileFacts facts = ColorFacts(frame->color.path);
        CheckSize(frame->color.path, facts.width, facts.height, camera.Picture(), kOtherColor);
        frame->color.hash = facts.hash;
      });
    }
    if (!frame->problem.empty()) frame->color.hash = "unreadable";
    InspectDepth(camera, frame);
    for (auto file = frame->others.begin(); file != frame->others.end();) {
      if (file->first == kConfidenceChannel) {
        ++file;
        continue;
      }
      const std::string problem = Problem(data_root_, file->second.path, [&] {
        const FileFacts facts = files_.Get(file->second.path, ReadLabelFacts);
        CheckLabel(file->second.path, facts, camera.Picture());
        file->second.hash = facts.hash;
      });
      if (!problem.empty()) frame->others_problems.push_back(problem);
      file = problem.empty() ? std::next(file) : frame->others.erase(file);
    }
  }

 private:
  FileFacts ColorFacts(const std::string& path) const {
    if (const auto parts = SplitVideoFramePath(path)) {
      const auto video = videos_.find(parts->first.generic_string());
      if (video != videos_.end()) return video->second;
    }
    return files_.Get(path, ReadPictureFacts);
  }

  void InspectDepth(const RgbdCamera& camera, RawFrame* frame) const {
    if (!frame->depth.path.empty() && frame->depth_problem.empty() && frame->problem.empty()) {
      frame->depth_problem = Problem(data_root_, frame->depth.path, [&] {
        const FileFacts facts = files_.Get(frame->depth.path, ReadPictureFacts);
        CheckDepth(frame->depth.path, facts, camera);
        frame->depth.hash = facts.hash;
      });
      InspectConfidence(camera, frame);
    }
    if (!frame->depth.hash.empty() && frame->depth_problem.empty()) return;
    frame->depth = {};
    frame->others.erase(kConfidenceChannel);
  }

  void InspectConfidence(const RgbdCamera& camera, RawFrame* frame) const {
    const auto confidence = frame->others.find(kConfidenceChannel);
    if (confidence == frame->others.end()) return;
    ChannelFile& file = confidence->second;
    const std::string problem = Problem(data_root_, file.path, [&] {
      const FileFacts facts = files_.Get(file.path, ReadLabelFacts);
      CheckConfidence(file.path, facts, camera);
      file.hash = facts.hash;
    });
    if (frame->depth_problem.empty()) frame->depth_problem = problem;
  }

  const fs::path& data_root_;
  const Videos& videos_;
  HashCache& files_;
};

}  // namespace

void InspectFrames(const std::vector<RgbdCamera>& cameras,
                   const fs::path& data_root,
                   HashCache& files,
                   Progress& progress,
                   int num_threads,
                   std::vector<RawSequence>* sequences) {
  std::vector<std::pair<RawFrame*, const RgbdCamera*>> work;
  for (RawSequence& sequence : *sequences) {
    for (RawFrame& frame : sequence.frames) {
      work.emplace_back(&frame, &cameras.at(static_cast<std::size_t>(frame.camera_idx)));
    }
  }
  const Videos videos = InspectVideos(*sequences, data_root, files);
  const FrameInspector inspector(data_root, videos, files);
  progress.Start(work.size());
  ParallelFor(work.size(), num_threads, [&](std::size_t i) {
    inspector.Inspect(*work[i].second, work[i].first);
    progress.Advance();
  });
}

}  // namespace nightmap
