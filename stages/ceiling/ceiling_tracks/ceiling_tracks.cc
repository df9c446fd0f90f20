// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_tracks/ceiling_tracks.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"

namespace nightmap {
namespace {

constexpr std::size_t kBatch_frames = 16;

struct ReadPicture {
  std::optional<FlowPyramid> picture;  // nothing: it cannot be read
  std::string failure;
};

// Reads the pictures of the next batch while those of the batch before are followed.
class PictureQueue {
 public:
  explicit PictureQueue(const CeilingTracksInput& input) : input_(input) {}

  std::size_t NumBatches() const {
    return (input_.frames.size() + kBatch_frames - 1) / kBatch_frames;
  }
  std::size_t NumIn(std::size_t batch) const {
    const std::size_t begin = std::min(batch * kBatch_frames, input_.frames.size());
    return std::min(kBatch_frames, input_.frames.size() - begin);
  }
  ReadPicture Read(std::size_t i) const {
    const FrameRecord& frame = input_.frames[i];
    ReadPicture read;
    read.failure =
        FrameFailure(frame.color.path, [&] { read.picture = PrepareForFlow(input_.load(frame)); });
    return read;
  }

 private:
  const CeilingTracksInput& input_;
};

}  // namespace

void KeepFramesFrom(int first_frame_idx, CeilingTracksInput* input) {
  std::erase_if(input->frames,
                [&](const FrameRecord& frame) { return frame.frame_idx < first_frame_idx - 1; });
  std::erase_if(input->features.frames,
                [&](const FrameFeatures& frame) { return frame.frame_idx < first_frame_idx - 1; });
}

CeilingTracksResult RunCeilingTracks(const CeilingTracksOptions& options,
                                     const CeilingTracksInput& input,
                                     Progress& progress,
                                     int num_threads) {
  CheckFeaturesOfFrames(input.frames, input.features);
  if (input.features.kind != DescriptorKind::kOrb) {
    throw InputError({{"features"}}, "has no ORB descriptors; set features.detector = \"harris\"");
  }
  CeilingTracksResult result;
  CornerTracker tracker(options.flow, options.new_corners);
  const auto follow = [&](std::size_t i, ReadPicture read) {
    const FrameRecord& frame = input.frames[i];
    if (!read.failure.empty()) result.skipped.push_back(read.failure);
    const auto camera = static_cast<std::size_t>(frame.camera_idx);
    tracker.Add(
        frame, input.cameras.at(camera).color, input.features.frames[i], std::move(read.picture));
    progress.Advance();
  };
  const PictureQueue queue(input);
  progress.Start(input.frames.size());
  std::vector<ReadPicture> ready;
  for (std::size_t batch = 0; batch <= queue.NumBatches(); ++batch) {
    std::vector<ReadPicture> next(queue.NumIn(batch));
    ParallelFor(next.size() + 1, num_threads, [&](std::size_t item) {
      if (item > 0) {
        next[item - 1] = queue.Read(batch * kBatch_frames + item - 1);
        return;
      }
      for (std::size_t k = 0; k < ready.size(); ++k) {
        follow((batch - 1) * kBatch_frames + k, std::move(ready[k]));
      }
    });
    ready = std::move(next);
  }
  result.num_ended = tracker.NumEnded();
  result.tracks = tracker.TakeTracks();
  return result;
}

}  // namespace nightmap
