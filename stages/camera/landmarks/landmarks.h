// SPDX-License-Identifier: Apache-2.0
// landmarks: joins keyframe features that show the same point into 3-D landmarks with descriptors,
// visual words and visibility. Pictures are localized against this map.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/camera/landmark_tracker.h"
#include "pipeline/camera/vocabulary_tree.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/landmarks_io.h"

namespace nightmap {

struct LandmarksOptions {
  OPTION(std::string, observers, "keyframes", {"keyframes", "all"},
         "described frames whose features make landmarks");
  LandmarkTrackerOptions tracker;
  OPTION_AT("max_error_px", tracker.max_error_px, {0.5, 50},
            "largest reprojection error of an observation");
  OPTION_AT("max_descriptor_distance", tracker.max_descriptor_distance, {0, 2},
            "largest descriptor distance between a landmark's observations; 1: as unrelated "
            "descriptors");
  OPTION_AT("voxel_size_m", tracker.voxel_size_m, {0.01, 10},
            "voxel edge of the index that finds landmarks");
  OPTION_AT("pixel_sigma_px", tracker.pixel_sigma_px, {0.1, 20},
            "standard deviation of a keypoint and its pose together");
  OPTION(int, min_observations, 1, {1, 100}, "a landmark with fewer observations is dropped");
  OPTION(double, max_position_sigma_m, 0.3, {0.001, 100},
         "a landmark with a larger standard deviation is dropped");
  OPTION(int, max_landmarks, 2000000, {1, 1e8},
         "largest number of landmarks; if there are more, each keyframe keeps as many of its most "
         "seen ones");
  REGISTER_OPTIONS();
};

struct LandmarksInput {
  std::vector<FrameRecord> frames;
  std::vector<RgbdCamera> cameras;
  FeaturesShard features;  // of all frames, in order
  const VocabularyTree* tree = nullptr;
  std::vector<StampedPose> trajectory;  // map_from_camera of every frame
  std::vector<StampedPose> keyframes;   // map_from_camera of the keyframes
};

struct LandmarksResult {
  LandmarkMap map;
  std::size_t num_found = 0;  // before max_landmarks cut the map

  std::size_t NumDropped() const { return num_found - map.positions_in_map.size(); }
};

// Observers (keyframes, or any posed frames) are processed in order of time. Each is compared only
// with landmarks in the voxels that its own depth falls into, so the work per observer does not
// grow with the map. A feature observes a landmark if it lies within max_error_px of the landmark's
// projection, at its depth, with a similar descriptor. A feature with depth that observes none
// founds a new landmark. A position is the mean of its observations weighted by information: the
// pixel noise across the ray and, where measured, the depth noise along it. Observations that
// disagree with the mean are dropped. If there are more than max_landmarks, ChooseLandmarks
// decides. Throws DataError, also for poses at times that no frame has. The same at any number of
// threads.
LandmarksResult RunLandmarks(const LandmarksOptions& options,
                             const LandmarksInput& input,
                             Progress& progress,
                             int num_threads);

}  // namespace nightmap
