// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/features/features.h"

#include <limits>
#include <optional>

#include "pipeline/base/parallel.h"
#include "pipeline/camera/keypoint_depth.h"
#include "pipeline/io/frame_failure.h"
#include "pipeline/io/frame_reader.h"

namespace nightmap {

namespace {

bool MayDescribe(const FeaturesInput& input, std::size_t i) {
  return !input.labelled || input.labelled->CanLabel(i);
}

// Describes or tracks the frames of one segment in order. A frame that throws is skipped: the next
// frame is tracked from the last described one, or described.
class Segment {
 public:
  Segment(const FeaturesOptions& options, const FeaturesInput& input, std::size_t first)
      : options_(options), input_(input), tracker_(options.tracking), last_labelled_(first) {}

  FrameFeatures Next(std::size_t i) {
    const FrameRecord& frame = input_.frames[i];
    RgbdImages images = input_.load(frame);
    is_labelled_ = false;
    if (input_.labelled && input_.labelled->IsDue(i, last_labelled_)) Label(i, &images);
    std::optional<FrameFeatures> features = Track(i, images);
    const bool is_tracked = features.has_value();
    if (!is_tracked) features = Describe(i, &images);
    features->frame_idx = frame.frame_idx;
    LookUpDepth(images.depth, &*features);
    if (!is_tracked) Start(i, images.color, *features);
    return std::move(*features);
  }

 private:
  const Camera& CameraOf(std::size_t i) const {
    return input_.cameras.at(static_cast<std::size_t>(input_.frames[i].camera_idx)).color;
  }

  // Nothing when the frame must be described.
  std::optional<FrameFeatures> Track(std::size_t i, const RgbdImages& images) {
    const FrameRecord& frame = input_.frames[i];
    const bool is_same_camera = frame.camera_idx == camera_idx_;
    if (MayDescribe(input_, i)) {
      const bool is_last = i + 1 == input_.frames.size();
      if (is_last || !is_same_camera) return std::nullopt;
      return tracker_.Track(images.color, CameraOf(i), frame.frame_idx, images.moving);
    }
    if (!is_same_camera) return FrameFeatures{};
    return tracker_.TrackFew(images.color, CameraOf(i), frame.frame_idx);
  }

  // Finds what moves, and takes it out.
  void Label(std::size_t i, RgbdImages* images) {
    MaskOut(input_.labelled->Label(i, *images), images);
    last_labelled_ = i;
    is_labelled_ = true;
  }

  FrameFeatures Describe(std::size_t i, RgbdImages* images) {
    if (input_.labelled && !is_labelled_) Label(i, images);
    return ExtractFeatures(images->color, CameraOf(i), options_.extraction, images->moving);
  }

  void Start(std::size_t i, const ColorImage& color, const FrameFeatures& described) {
    tracker_.Start(color, CameraOf(i), described);
    camera_idx_ = input_.frames[i].camera_idx;
  }

  const FeaturesOptions& options_;
  const FeaturesInput& input_;
  FeatureTracker tracker_;
  std::size_t last_labelled_;  // a frame; at first the segment's, which is described in any case
  bool is_labelled_ = false;   // the frame at hand
  int camera_idx_ = -1;        // of the described frame that the tracker follows
};

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

std::vector<RgbdCamera> WithoutMaxDepth(std::vector<RgbdCamera> cameras) {
  for (RgbdCamera& camera : cameras) camera.max_depth_m = std::numeric_limits<double>::infinity();
  return cameras;
}

FeaturesResult RunFeatures(const FeaturesOptions& options,
                           const FeaturesInput& input,
                           Progress& progress,
                           int num_threads) {
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
    Segment segment(options, input, bounds[i]);
    for (std::size_t k = bounds[i]; k < bounds[i + 1]; ++k) {
      result.shard.frames[k].frame_idx = frames[k].frame_idx;
      failures[k] =
          FrameFailure(frames[k].color.path, [&] { result.shard.frames[k] = segment.Next(k); });
      progress.Advance();
    }
  });
  for (const std::string& failure : failures) {
    if (!failure.empty()) result.skipped.push_back(failure);
  }
  return result;
}

}  // namespace nightmap
