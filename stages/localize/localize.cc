// SPDX-License-Identifier: Apache-2.0
#include "stages/localize/localize.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "stages/localize/localizer.h"

namespace nightmap {
namespace {

void CheckInput(const LocalizeInput& input) {
  const LandmarkMap& map = *input.map;
  const VocabularyTree& tree = input.vocabulary->tree;
  if (input.queries.empty()) {
    throw DataError(
        "queries: no queries to localize; set hold_out_every or add a [[query]] to the site");
  }
  if (map.NumLandmarks() == 0) throw DataError("landmarks: the map is empty; see its report");
  const auto max_word = std::max_element(map.words.begin(), map.words.end());
  if (tree.Kind() != map.kind || input.extraction.Kind() != map.kind ||
      tree.Depth() != map.num_word_levels || *max_word >= tree.NumNodes()) {
    throw DataError("landmarks: made with another vocabulary; run the landmarks stage again");
  }
  for (const FrameRecord& query : input.queries) {
    if (query.camera_idx < 0 || query.camera_idx >= static_cast<int>(input.cameras.size())) {
      throw DataError(
          "queries: query {} has camera_idx {} out of range", query.frame_idx, query.camera_idx);
    }
  }
}

QueryResult LocalizeQuery(const Localizer& localizer,
                          const LocalizeInput& input,
                          const FrameRecord& query) {
  const RgbdCamera& camera = input.cameras[static_cast<std::size_t>(query.camera_idx)];
  FrameFeatures features;
  try {
    const ColorImage image = input.load_color(query, camera);
    features = ExtractFeatures(image, camera.color, input.extraction);
  } catch (const DataError&) {
    return FailedQuery(query, "unreadable_image");
  }
  return localizer.Localize(query, camera.color, features);
}

}  // namespace

void LocalizeOptions::Register(OptionList& list) {
  list.Add("search_level", &search_level, Range(1, 8), "vocabulary level of the candidates");
  list.Add("max_ratio", &max_ratio, Range(0.1, 1), "of the ratio test between two points");
  list.Add("same_point_radius_m",
           &same_point_radius_m,
           Range(0, 10),
           "landmarks as near as this are no rivals in the ratio test");
  list.Add("max_matches", &max_matches, Range(4, 100000), "the search by words ends with as many");
  list.Add("num_retrieved_keyframes",
           &num_retrieved_keyframes,
           Range(1, 1000),
           "searched when the words gave no pose");
  list.Add("num_guided_keyframes",
           &num_guided_keyframes,
           Range(1, 1000),
           "whose landmarks are projected with the first pose");
  list.Add("guided_radius_px", &guided_radius_px, Range(1, 100), "of the search with a first pose");
  list.Add("max_descriptor_distance",
           &max_descriptor_distance,
           Range(0, 2),
           "of a match; 1: as unrelated descriptors");
  list.Add("max_error_px", &max_error_px, Range(0.5, 50), "reprojection error of an inlier");
  list.Add("max_iterations", &max_iterations, Range(10, 1e6), "of RANSAC");
  list.Add("min_seed_inliers", &min_seed_inliers, Range(4, 1000), "of the first pose");
  list.Add("min_inliers", &min_inliers, Range(4, 1000), "of the final pose; fewer: not located");
  list.Add("seed", &seed, Range(0, 2e9), "of RANSAC");
}

std::vector<QueryResult> RunLocalize(const LocalizeOptions& options,
                                     const LocalizeInput& input,
                                     Progress& progress,
                                     int num_threads) {
  CheckInput(input);
  const Localizer localizer(options, *input.map, *input.vocabulary);
  std::vector<QueryResult> results(input.queries.size());
  progress.Start(results.size());
  ParallelFor(results.size(), num_threads, [&](std::size_t i) {
    results[i] = LocalizeQuery(localizer, input, input.queries[i]);
    progress.Advance();
  });
  progress.Finish();
  return results;
}

}  // namespace nightmap
