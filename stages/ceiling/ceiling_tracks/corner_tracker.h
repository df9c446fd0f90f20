// SPDX-License-Identifier: Apache-2.0
// Follows corners through the pictures of one camera, in order, and takes new ones where none are.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "pipeline/ceiling/corner_tracks_io.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"
#include "stages/ceiling/ceiling_tracks/corner_flow.h"
#include "stages/ceiling/ceiling_tracks/new_corners.h"

namespace nightmap {

using TrackEndCounts = std::array<int, static_cast<std::size_t>(kNumTrackEnds)>;

class CornerTracker {
 public:
  CornerTracker(const FlowOptions& flow, const NewCornerOptions& new_corners)
      : flow_(flow), new_corners_(new_corners) {}

  // Adds the next frame to the tracks. `picture` is nothing when it cannot be read: all tracks end.
  // They also end before the first frame of another camera or sequence. `features` are the corners
  // of the frame, with ORB descriptors; a frame that is not described begins no tracks.
  void Add(const FrameRecord& frame,
           const Camera& camera,
           const FrameFeatures& features,
           std::optional<FlowPyramid> picture);

  CornerTracks TakeTracks() { return std::move(tracks_); }
  const TrackEndCounts& NumEnded() const { return num_ended_; }

 private:
  struct Track {
    std::int64_t id = 0;
    Eigen::Vector2f raw_px = Eigen::Vector2f::Zero();
    Eigen::Vector2f px = Eigen::Vector2f::Zero();
    Eigen::Vector2f step_px = Eigen::Vector2f::Zero();  // raw, from the frame before
  };
  void Follow(const Camera& camera, const FlowPyramid& picture, TrackedFrame* tracked);
  void Begin(const Camera& camera, const FrameFeatures& features, TrackedFrame* tracked);
  void End(TrackEnd reason) { ++num_ended_[static_cast<std::size_t>(reason)]; }

  FlowOptions flow_;
  NewCornerOptions new_corners_;
  std::optional<FlowPyramid> last_picture_;
  int camera_idx_ = -1;       // of the last frame
  int sequence_idx_ = -1;     // of the last frame
  std::vector<Track> alive_;  // ascending id
  Eigen::Vector2f median_step_px_ = Eigen::Vector2f::Zero();
  CornerTracks tracks_;
  TrackEndCounts num_ended_{};
};

}  // namespace nightmap
