// SPDX-License-Identifier: Apache-2.0
// localize: finds the pose of each query picture. Uses only the picture, never its depth.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/camera/extract_features.h"
#include "pipeline/camera/vocabulary_io.h"
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
  ExtractionOptions extraction;  // those that made the map's features
  const LandmarkMap* map = nullptr;
  const Vocabulary* vocabulary = nullptr;
  // The color image of a query; throws DataError when it cannot be read.
  std::function<ColorImage(const FrameRecord&, const RgbdCamera&)> load_color;
  // Called with the reason why a picture could not be read, in the order of the queries.
  std::function<void(const std::string&)> skip = [](const std::string&) {};
  // Called when the work on features (`extract`) and that on poses (`locate`) begins, in turn, by
  // the thread that begins it. Other threads may still be extracting the last features when
  // `locate` begins.
  std::function<void(const char*)> begin_part = [](const char*) {};
  // The cameras that recorded the map; if empty, no picture is scaled.
  std::vector<RgbdCamera> map_cameras = {};
};

// One result per query, in their order; see QueryVerdict. Reasons: too_few_matches,
// too_few_inliers, uncertain_pose and mirrored (not in the map), rival_place (ambiguous),
// no_features, unreadable_image, search_failed (unreadable as well: the search ran out of memory).
// A picture much finer than the map's (max_focal_ratio) is scaled down to the map's focal length
// before it is described. Thresholds in pixels and feature scales then mean the same as in the map;
// errors are in pixels of the scaled picture. A lens that is not calibrated (focal_sigma_ratio) is
// estimated with the pose.
//
// Method: active search as published in CN106940186A, or one of its parts by option, with these
// improvements: prioritized search (Sattler, Leibe, Kobbelt, ICCV 2011 and ECCV 2012), covisible
// matches only, P3P, a second search around the first pose, retrieval where words find no pose, and
// camera motion during a rolling shutter (the pose is that of the middle row).
//
// Deterministic in the seed at any number of threads. Throws DataError without queries or
// landmarks, or when map and vocabulary do not belong together.
std::vector<QueryResult> RunLocalize(const LocalizeOptions& options,
                                     const LocalizeInput& input,
                                     Progress& progress,
                                     int num_threads);

}  // namespace nightmap
