// SPDX-License-Identifier: Apache-2.0
// landmarks: joins keyframe features that show the same point into 3-D landmarks with descriptors,
// visual words and visibility. Pictures are localized against this map.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/camera/landmark_tracker.h"
#include "pipeline/camera/vocabulary_tree.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/landmark_map.h"
#include "pipeline/io/site_features.h"

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
  OPTION(int, max_landmarks, 100000000, {1, 1e9},
         "largest number of landmarks, above that of a night; localize takes memory for each; if "
         "there are more, each keyframe keeps as many of its most seen ones");
  REGISTER_OPTIONS();
};

struct LandmarksInput {
  std::vector<FrameRecord> frames;
  std::vector<RgbdCamera> cameras;
  SiteFeatures features;  // of these frames, in order
  const VocabularyTree* tree = nullptr;
  std::vector<StampedPose> trajectory;  // map_from_camera of every frame
  std::vector<StampedPose> keyframes;   // map_from_camera of the keyframes
  // A region with more is cut. A few such regions are in memory at a time.
  std::size_t max_region_observers = 1000;
};

struct LandmarksFigures {
  std::size_t num_observers = 0;
  std::size_t num_regions = 0;
  std::size_t num_found = 0;  // before max_landmarks cut the map
  std::size_t num_landmarks = 0;
  std::size_t num_descriptors = 0;
  std::size_t num_observations = 0;

  std::size_t NumDropped() const { return num_found - num_landmarks; }
};

// The map without landmarks; its keyframes are the observers, in order of time. Throws DataError,
// also for poses at times that no frame has.
LandmarkMap HeadOfMap(const LandmarksOptions& options, const LandmarksInput& input);

// Takes a region of the map: its box, and the landmarks in it, whose keyframes are those of the
// head.
using TakeRegion = std::function<void(const Rectangle&, const LandmarkMap&)>;

// Observers (keyframes, or any posed frames) are processed in order of time. Each is compared only
// with landmarks in the voxels that its own depth falls into, so the work per observer does not
// grow with the map. A feature observes a landmark if it lies within max_error_px of the landmark's
// projection, at its depth, with a similar descriptor. A feature with depth that observes none
// founds a new landmark. A position is the mean of its observations weighted by information: the
// pixel noise across the ray and, where measured, the depth noise along it. Observations that
// disagree with the mean are dropped. If there are more than max_landmarks, ChooseLandmarks
// decides, and a region has its share by the observers that stand in it.
//
// Regions partition the plane and are built one by one, from the features in and near their boxes;
// a landmark is of the region that it lies in. Memory is that of a few regions, a bit for each
// feature, and of `input`. No two landmarks show the same feature. At the borders, landmarks are
// those of one large region but for the few that compete with something beyond the margin.
//
// Throws DataError, as HeadOfMap. The same at any number of threads.
LandmarksFigures RunLandmarks(const LandmarksOptions& options,
                              const LandmarksInput& input,
                              const TakeRegion& take_region,
                              Progress& progress,
                              int num_threads);

}  // namespace nightmap
