// SPDX-License-Identifier: Apache-2.0
// landmarks: joins the keyframes' features that show the same point to 3-D landmarks with
// descriptors, visual words and visibility: the map that pictures are localized against.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/features/landmark_tracker.h"
#include "pipeline/features/vocabulary_tree.h"
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

// Each observer (a keyframe, or any posed frame), in order of time, is compared only with landmarks
// in the voxels its own depth falls into, so the work of one does not grow with the map. A feature
// within max_error_px of a projected landmark, at its depth and with a similar descriptor, observes
// it; another feature with depth founds one. A position is the mean of its observations weighted by
// information: a pixel across the ray and, where measured, the depth's noise along it. Observations
// that do not agree with the mean are dropped. Of more than max_landmarks each observer keeps as
// many as any other (see ChooseLandmarks). Poses whose time is no frame's are refused. Throws
// DataError; the same at any number of threads.
LandmarksResult RunLandmarks(const LandmarksOptions& options,
                             const LandmarksInput& input,
                             Progress& progress,
                             int num_threads);

}  // namespace nightmap
