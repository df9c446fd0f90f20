// SPDX-License-Identifier: Apache-2.0
#include "stages/features/features.h"

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
    std::optional<FrameFeatures> tracked;
    if (!must_describe && frame.camera_idx == camera_idx_) {
      tracked = tracker_.Track(images.color, CameraOf(frame), frame.frame_idx, images.moving);
    }
    FrameFeatures features =
        tracked
            ? std::move(*tracked)
            : ExtractFeatures(images.color, CameraOf(frame), options_.extraction, images.moving);
    features.frame_idx = frame.frame_idx;
    LookUpDepth(images.depth, options_.extraction, &features);
    if (!tracked) tracker_.Start(images.color, CameraOf(frame), features);
    camera_idx_ = frame.camera_idx;
    return features;
  }

  // For a frame that may not be described.
  FrameFeatures Follow(const FrameRecord& frame, const RgbdImages& images) {
    FrameFeatures features;
    features.frame_idx = frame.frame_idx;
    if (frame.camera_idx != camera_idx_) return features;
    features = tracker_.TrackFew(images.color, CameraOf(frame), frame.frame_idx);
    LookUpDepth(images.depth, options_.extraction, &features);
    return features;
  }

 private:
  const Camera& CameraOf(const FrameRecord& frame) const {
    return cameras_.at(static_cast<std::size_t>(frame.camera_idx)).color;
  }

  const FeaturesOptions& options_;
  const std::vector<RgbdCamera>& cameras_;
  FeatureTracker tracker_;
  int camera_idx_ = -1;  // of the previous frame
};

bool MayDescribe(const FeaturesInput& input, std::size_t i) {
  return input.may_describe.empty() || input.may_describe[i];
}

// First frame of each segment, and the number of frames.
std::vector<std::size_t> SegmentBounds(const FeaturesInput& input, std::size_t length) {
  const std::size_t count = input.frames.size();
  std::vector<std::size_t> bounds = {0};
  for (std::size_t begin = length; begin < count; begin += length) {
    std::size_t first = begin;
    while (first < count && !MayDescribe(input, first)) ++first;
    if (first > bounds.back()) bounds.push_back(first);
  }
  if (bounds.back() < count) bounds.push_back(count);
  return bounds;
}

}  // namespace

FeaturesResult RunFeatures(const FeaturesOptions& options,
                           const FeaturesInput& input,
                           int num_threads,
                           Progress& progress) {
  const std::vector<FrameRecord>& frames = input.frames;
  FeaturesResult result;
  ExtractionOptions extraction = options.extraction;
  result.shard.extraction = RegisterOptions(extraction).ToToml();
  result.shard.kind = options.extraction.Kind();
  result.shard.descriptor_size = DescriptorSize(result.shard.kind);
  result.shard.frames.resize(frames.size());
  std::vector<std::string> failures(frames.size());
  const auto bounds = SegmentBounds(input, static_cast<std::size_t>(options.segment_frames));
  progress.Start(frames.size());
  ParallelFor(bounds.size() - 1, num_threads, [&](std::size_t i) {
    Segment segment(options, input.cameras);
    for (std::size_t k = bounds[i]; k < bounds[i + 1]; ++k) {
      result.shard.frames[k].frame_idx = frames[k].frame_idx;
      failures[k] = FrameFailure(frames[k].color.path, [&] {
        const RgbdImages images = input.load(frames[k]);
        const bool is_last = k + 1 == frames.size();
        result.shard.frames[k] = MayDescribe(input, k) ? segment.Next(frames[k], images, is_last)
                                                       : segment.Follow(frames[k], images);
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
