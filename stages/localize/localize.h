// SPDX-License-Identifier: Apache-2.0
// localize: where was each query picture taken? Only the picture is used, never its depth.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/features/extract_features.h"
#include "pipeline/features/vocabulary_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/landmarks_io.h"
#include "pipeline/io/queries_io.h"

namespace nightmap {

struct LocalizeOptions {
  std::string search = "combined";
  int search_level = 3;
  int max_word_descriptors = 500;
  double max_ratio = 0.8;
  double same_point_radius_m = 0.1;
  int num_nearest_landmarks = 50;
  int landmark_level = 5;
  double max_landmark_ratio = 0.8;
  bool prioritized = true;
  bool covisibility_filter = true;
  int max_matches = 300;
  int num_tree_checks = 200;
  double max_descriptor_distance = 0.7;
  double max_focal_ratio = 1.5;
  std::string solver = "p3p";
  bool local_optimization = true;
  bool refinement = true;
  double readout_turn_sigma_rad = 0.005;
  double readout_shift_sigma_m = 0.002;
  double max_error_px = 4.0;
  int max_iterations = 2000;
  int min_seed_inliers = 8;
  int num_retrieved_keyframes = 5;
  int num_guided_keyframes = 10;
  double guided_radius_px = 10.0;
  int min_inliers = 12;
  double min_inlier_significance = 8.0;
  double max_position_sigma_m = 0.5;
  double rival_distance_m = 1.0;
  double max_rival_ratio = 0.5;
  double min_rival_significance = 4.0;
  int seed = 0;

  void Register(OptionList& list);
};

struct LocalizeInput {
  std::vector<FrameRecord> queries;
  std::vector<RgbdCamera> cameras;
  ExtractionOptions extraction;  // as the map's features were made
  const LandmarkMap* map = nullptr;
  const Vocabulary* vocabulary = nullptr;
  // The color image of a query; throws DataError when it cannot be read.
  std::function<ColorImage(const FrameRecord&, const RgbdCamera&)> load_color;
  // Told why a picture could not be read, in the order of the queries.
  std::function<void(const std::string&)> skip = [](const std::string&) {};
  // Told when the work on features (`extract`) and that on poses (`locate`) begins, in turn, by the
  // thread that begins it. The last features are then still being extracted by other threads.
  std::function<void(const char*)> begin_part = [](const char*) {};
  // Those that recorded the map; without any no picture is scaled.
  std::vector<RgbdCamera> map_cameras = {};
};

// One result a query, in their order; see QueryVerdict. Reasons: too_few_matches, too_few_inliers
// and uncertain_pose (not in the map), rival_place (ambiguous), no_features, unreadable_image,
// search_failed (unreadable as well: the search had too little memory).
// A picture much finer than the map's (max_focal_ratio) is scaled down to the focal length of the
// map before it is described: thresholds in pixels and the features' scales then mean what they
// mean in the map, and errors are in pixels of the scaled picture.
// Active search as published in CN106940186A, or by the options one of its parts, with what makes
// it better: prioritized search (Sattler, Leibe, Kobbelt, ICCV 2011 and ECCV 2012), covisible
// matches only, P3P, a second search around the first pose, retrieval where words lead nowhere, and
// the camera's motion while its shutter rolls (the pose is that of the middle row).
// Deterministic in the seed, at any number of threads. Throws DataError without queries or
// landmarks or when map and vocabulary do not belong together.
std::vector<QueryResult> RunLocalize(const LocalizeOptions& options,
                                     const LocalizeInput& input,
                                     Progress& progress,
                                     int num_threads);

}  // namespace nightmap
