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
  std::string observers = "keyframes";
  LandmarkTrackerOptions tracker;
  int min_observations = 1;
  double max_position_sigma_m = 0.3;
  int max_landmarks = 2000000;
  int max_descriptors = 3;
  double min_descriptor_difference = 0.3;

  void Register(OptionList& list);
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
