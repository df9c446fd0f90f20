// SPDX-License-Identifier: Apache-2.0
#include "stages/features/features.h"

#include <algorithm>
#include <optional>

#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"

namespace nightmap {

namespace {

// Describes or tracks the frames of one segment in order. A frame that throws is skipped: the next
// frame is tracked from the last described one, or described.
class Segment {
 public:
  Segment(const FeaturesOptions& options, const std::vector<RgbdCamera>& cameras)
      : options_(options), cameras_(cameras), tracker_(options.tracking) {}

  FrameFeatures Next(const FrameRecord& frame, const RgbdImages& images, bool must_describe) {
    const Camera& camera = cameras_.at(static_cast<std::size_t>(frame.camera_idx)).color;
    std::optional<FrameFeatures> tracked;
    if (!must_describe && frame.camera_idx == camera_idx_) {
      tracked = tracker_.Track(images.color, camera, frame.frame_idx);
    }
    FrameFeatures features =
        tracked ? std::move(*tracked) : ExtractFeatures(images.color, camera, options_.extraction);
    features.frame_idx = frame.frame_idx;
    LookUpDepth(images.depth, options_.extraction, &features);
    if (!tracked) tracker_.Start(images.color, camera, features);
    camera_idx_ = frame.camera_idx;
    return features;
  }

 private:
  const FeaturesOptions& options_;
  const std::vector<RgbdCamera>& cameras_;
  FeatureTracker tracker_;
  int camera_idx_ = -1;  // of the previous frame
};

}  // namespace

FeaturesResult RunFeatures(const FeaturesOptions& options,
                           const std::vector<FrameRecord>& frames,
                           const std::vector<RgbdCamera>& cameras,
                           const RgbdLoader& load,
                           int num_threads,
                           Progress& progress) {
  FeaturesResult result;
  ExtractionOptions extraction = options.extraction;
  result.shard.extraction = RegisterOptions(extraction).ToToml();
  result.shard.kind = options.extraction.Kind();
  result.shard.descriptor_size = DescriptorSize(result.shard.kind);
  result.shard.frames.resize(frames.size());
  std::vector<std::string> failures(frames.size());
  const auto length = static_cast<std::size_t>(options.segment_frames);
  progress.Start(frames.size());
  ParallelFor((frames.size() + length - 1) / length, num_threads, [&](std::size_t i) {
    Segment segment(options, cameras);
    for (std::size_t k = i * length; k < std::min(frames.size(), (i + 1) * length); ++k) {
      result.shard.frames[k].frame_idx = frames[k].frame_idx;
      failures[k] = FrameFailure(frames[k].color.path, [&] {
        const bool is_last = k + 1 == frames.size();
        result.shard.frames[k] = segment.Next(frames[k], load(frames[k]), is_last);
      });
      progress.Advance();
    }
  });
  for (const std::string& failure : failures) {
    if (!failure.empty()) result.skipped.push_back(failure);
  }
  return result;
}

}  // namespace nightmap
