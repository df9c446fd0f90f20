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
  OPTION(std::string, search, "combined", {"combined", "2d_to_3d", "3d_to_2d", "tree"},
         "combined: 2-D to 3-D, then 3-D to 2-D around each match; or only one of them; or by "
         "tree");
  OPTION(int, search_level, 3, {1, 8}, "vocabulary level of the 2-D to 3-D search");
  OPTION(int, max_word_descriptors, 500, {1, 1e9},
         "a feature's word with more descriptors is replaced by one of a deeper level");
  OPTION(double, max_ratio, 0.8, {0.1, 1}, "largest ratio in the ratio test between two landmarks");
  OPTION(double, same_point_radius_m, 0.1, {0, 10},
         "landmarks within this distance are no rivals in the ratio test");
  OPTION(int, num_nearest_landmarks, 50, {0, 10000},
         "landmarks around each match that 3-D to 2-D searches");
  OPTION(int, landmark_level, 5, {1, 8}, "vocabulary level of the 3-D to 2-D search");
  OPTION(double, max_landmark_ratio, 0.8, {0.1, 1},
         "largest ratio in the ratio test between two features of the picture");
  OPTION(bool, prioritized, true,
         "takes the cheapest step of both directions next; false: takes 3-D to 2-D steps at once");
  OPTION(bool, covisibility_filter, true,
         "keeps only neighbours and matches that keyframes see together");
  OPTION(int, max_matches, 300, {4, 100000}, "matches after which the search ends");
  OPTION(double, max_descriptor_distance, 0.7, {0, 2},
         "largest descriptor distance of a match; 1: as unrelated descriptors");
  OPTION(double, max_focal_ratio, 1.5, {1, 1000},
         "largest ratio of a picture's focal length to the map's, in px; finer pictures are scaled "
         "down to the map's");
  OPTION(std::string, solver, "p3p", {"p3p", "dlt6"},
         "solver for RANSAC samples of 3 matches, or of 6");
  OPTION(bool, local_optimization, true, "optimizes each best sample of RANSAC");
  OPTION(bool, refinement, true, "refines the pose by robust least squares over the inliers");
  OPTION(double, readout_turn_sigma_rad, 0.005, {0, 1},
         "expected rotation of the camera from a picture's first row to its last; 0: global "
         "shutter");
  OPTION(double, max_error_px, 4.0, {0.5, 50}, "largest reprojection error of an inlier");
  OPTION(int, max_iterations, 2000, {10, 1e6}, "RANSAC iterations");
  OPTION(int, num_retrieved_keyframes, 5, {0, 1000},
         "keyframes to search when the words gave no pose; 0: none");
  OPTION(int, num_guided_keyframes, 10, {0, 1000},
         "keyframes whose landmarks are projected with the first pose; 0: no second search");
  OPTION(double, guided_radius_px, 10.0, {1, 100},
         "search radius around landmarks projected with the first pose");
  OPTION(int, min_inliers, 12, {4, 1000},
         "smallest number of inliers of the final pose; fewer: not in the map");
  OPTION(double, min_inlier_significance, 8.0, {0, 1000},
         "smallest excess of inliers over a wrong pose, in standard deviations; less: not in the "
         "map");
  OPTION(double, max_position_sigma_m, 0.5, {0.001, 1000},
         "largest standard deviation of the position; more: not in the map");
  OPTION(double, rival_distance_m, 1.0, {0.01, 1000},
         "landmarks, and poses, at least this far apart are different places");
  OPTION(double, max_rival_ratio, 0.5, {0, 1},
         "largest share of inliers in another place; more: the features vote; 1: does not search "
         "for other places");
  OPTION(double, min_rival_significance, 4.0, {0, 1000},
         "smallest lead in the vote, in standard deviations; less: ambiguous");
  OPTION(int, seed, 0, {0, 2e9}, "seed of RANSAC");
  REGISTER_OPTIONS();
};

// The map, of which each region can be read alone.
struct MapInRegions {
  LandmarkMap head;  // the map without landmarks
  std::vector<LandmarkRegion> regions;
  // The landmarks of a region, as LandmarksReader::Read gives them. Called by one thread at a time.
  std::function<LandmarkMap(std::size_t)> read;
};

// Bounds of the memory for the map. Results of a map that is searched whole do not depend on them.
struct MapLimits {
  std::int64_t whole_landmarks = 1'000'000;  // a map with more is searched in parts
  std::int64_t part_landmarks = 1'000'000;   // largest size of a part of several regions
  int parts_per_picture = 3;
  std::size_t bytes = std::size_t{1} << 30;  // of the parts in memory
};

struct LocalizeInput {
  std::vector<FrameRecord> queries;
  std::vector<RgbdCamera> cameras;
  ExtractionOptions extraction;  // those that made the map's features
  const MapInRegions* map = nullptr;
  const VocabularyIndex* vocabulary = nullptr;
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
  MapLimits limits = {};
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
// A map of more than limits.whole_landmarks is searched in parts (map_parts.h): a picture in those
// whose keyframes have most of its words, and in parts much less alike only if it was not located.
// The place with the most inliers wins, and a pose in another part is a rival place.
//
// Deterministic in the seed at any number of threads. Throws DataError without queries or
// landmarks, or when map and vocabulary do not belong together.
std::vector<QueryResult> RunLocalize(const LocalizeOptions& options,
                                     const LocalizeInput& input,
                                     Progress& progress,
                                     int num_threads);

}  // namespace nightmap
