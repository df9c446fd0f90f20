// SPDX-License-Identifier: Apache-2.0
// ceiling_tracks: corners of the ceiling followed from picture to picture of an upward camera.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/ceiling/corner_tracks_io.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"
#include "stages/ceiling/ceiling_tracks/corner_tracker.h"

namespace nightmap {

struct CeilingTracksOptions {
  OPTIONS_OF(FlowOptions, flow);
  OPTIONS_OF(NewCornerOptions, new_corners);
  OPTION(double, max_failed_ratio, 0.2, {0, 1}, "fails when a larger share of the frames failed");
  REGISTER_OPTIONS();
};

struct CeilingTracksInput {
  std::vector<FrameRecord> frames;  // the last frame of the shard before, if any, then the shard's
  std::vector<RgbdCamera> cameras;
  FeaturesShard features;  // of these frames, in their order
  // Throws when the picture cannot be read. Several threads may load at once.
  std::function<GrayImage(const FrameRecord&)> load;
};

struct CeilingTracksResult {
  CornerTracks tracks;
  TrackEndCounts num_ended{};
  std::vector<std::string> skipped;  // reasons, in frame order
};

// Drops the frames before the last one of the shard before, and their features.
void KeepFramesFrom(int first_frame_idx, CeilingTracksInput* input);

// Follows every track from frame to frame until it ends. A frame that cannot be read has no
// sightings, and tracks end there. Throws InputError when the features have no ORB descriptors, or
// are not of these frames. Deterministic at any number of threads: pictures are read ahead in
// parallel, and followed in order.
CeilingTracksResult RunCeilingTracks(const CeilingTracksOptions& options,
                                     const CeilingTracksInput& input,
                                     Progress& progress,
                                     int num_threads);

}  // namespace nightmap
