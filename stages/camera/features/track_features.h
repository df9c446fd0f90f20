// SPDX-License-Identifier: Apache-2.0
// Tracks features by optical flow from a described frame to the frames after it, so that only some
// frames need descriptors (pyramidal Lucas-Kanade: Bouguet, Pyramidal implementation of the Lucas
// Kanade feature tracker, 2000). The reference patch is always the described frame's, so tracks do
// not drift.
#pragma once

#include <memory>
#include <optional>

#include "pipeline/base/options.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

struct TrackingOptions {
  OPTION(int, max_gap_frames, 10, {0, 1000},
         "largest number of frames tracked after a described one; 0: describes every frame");
  OPTION(int, max_tracked, 400, {20, 20000}, "largest number of features tracked, strongest first");
  REGISTER_OPTIONS();
};

// Deterministic; one thread.
class FeatureTracker {
 public:
  explicit FeatureTracker(const TrackingOptions& options);
  FeatureTracker(FeatureTracker&&) noexcept;
  ~FeatureTracker();

  // Restarts from a described frame.
  void Start(const ColorImage& color, const Camera& camera, const FrameFeatures& described);

  // The features found again in the next frame, without depth (depths_m all 0) or descriptors.
  // Returns nothing when so few are found, or so many frames have passed, that this frame should be
  // described; also before Start. Features that run into the mask `moving` end.
  std::optional<FrameFeatures> Track(const ColorImage& color,
                                     const Camera& camera,
                                     int frame_idx,
                                     const GrayImage& moving = {});
  // For a frame that may not be described: returns what is found, however little.
  FrameFeatures TrackFew(const ColorImage& color, const Camera& camera, int frame_idx);

 private:
  struct State;

  TrackingOptions options_;
  std::unique_ptr<State> state_;
};

}  // namespace nightmap
