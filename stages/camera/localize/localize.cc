// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/localize.h"

#include <algorithm>
#include <future>
#include <span>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "stages/camera/localize/describe_picture.h"
#include "stages/camera/localize/localizer.h"

namespace nightmap {
namespace {

void CheckInput(const LocalizeInput& input) {
  const LandmarkMap& map = *input.map;
  const VocabularyTree& tree = input.vocabulary->tree;
  if (input.queries.empty()) {
    throw DataError(
        "queries: no queries to localize; set hold_out_every or add a [[query]] to the site");
  }
  if (map.NumLandmarks() == 0) throw InputError({{"landmarks"}}, "the map is empty");
  const auto max_word = std::max_element(map.words.begin(), map.words.end());
  if (tree.Kind() != map.kind || input.extraction.Kind() != map.kind ||
      tree.Depth() != map.num_word_levels || *max_word >= tree.NumNodes()) {
    throw InputError({{"landmarks"}, {"vocabulary"}}, "made with another vocabulary");
  }
  for (const FrameRecord& query : input.queries) {
    if (query.camera_idx < 0 || query.camera_idx >= static_cast<int>(input.cameras.size())) {
      throw DataError(
          "queries: query {} has camera_idx {} out of range", query.frame_idx, query.camera_idx);
    }
  }
}

struct LocatedPicture {
  QueryResult result;
  std::string problem;  // why the picture could not be used
};

// Describes all pictures, then locates all, in one loop: a thread with no picture left to describe
// goes on to locate, so none waits for the slowest picture.
std::vector<LocatedPicture> LocateBatch(const LocalizeOptions& options,
                                        const LocalizeInput& input,
                                        const Localizer& localizer,
                                        std::span<const FrameRecord> queries,
                                        Progress& progress,
                                        int num_threads) {
  std::vector<std::packaged_task<DescribedPicture()>> describe;
  std::vector<std::future<DescribedPicture>> described;
  for (const FrameRecord& query : queries) {
    describe.emplace_back([&] { return DescribePicture(options, input, query); });
    described.push_back(describe.back().get_future());
  }
  std::vector<LocatedPicture> located(queries.size());
  const auto locate = [&](std::size_t i) {
    const DescribedPicture picture = described[i].get();
    LocatedPicture& found = located[i];
    found.problem = picture.problem;
    if (found.problem.empty()) {
      found.problem = FrameFailure(queries[i].color.path, [&] {
        found.result = localizer.Localize(queries[i], picture.lens, picture.features);
      });
    }
    if (found.problem.empty()) return;
    const char* reason = picture.problem.empty() ? "search_failed" : "unreadable_image";
    found.result = FailedQuery(queries[i], QueryVerdict::kUnreadable, reason);
  };
  input.begin_part("extract");
  ParallelFor(2 * queries.size(), num_threads, [&](std::size_t i) {
    if (i == queries.size()) input.begin_part("locate");
    i < queries.size() ? describe[i]() : locate(i - queries.size());
    progress.Advance();
  });
  return located;
}

}  // namespace

void LocalizeOptions::Register(OptionList& list) {
  list.Add(
      "search",
      &search,
      {"combined", "2d_to_3d", "3d_to_2d", "tree"},
      "combined: 2-D to 3-D, then 3-D to 2-D around each match; or only one of them; or by tree");
  list.Add("search_level", &search_level, Range(1, 8), "vocabulary level of the 2-D to 3-D search");
  list.Add("max_word_descriptors",
           &max_word_descriptors,
           Range(1, 1e9),
           "a feature's word with more descriptors is replaced by one of a deeper level");
  list.Add("max_ratio",
           &max_ratio,
           Range(0.1, 1),
           "largest ratio in the ratio test between two landmarks");
  list.Add("same_point_radius_m",
           &same_point_radius_m,
           Range(0, 10),
           "landmarks within this distance are no rivals in the ratio test");
  list.Add("num_nearest_landmarks",
           &num_nearest_landmarks,
           Range(0, 10000),
           "landmarks around each match that 3-D to 2-D searches");
  list.Add(
      "landmark_level", &landmark_level, Range(1, 8), "vocabulary level of the 3-D to 2-D search");
  list.Add("max_landmark_ratio",
           &max_landmark_ratio,
           Range(0.1, 1),
           "largest ratio in the ratio test between two features of the picture");
  list.Add(
      "prioritized",
      &prioritized,
      "takes the cheapest step of both directions next; false: takes 3-D to 2-D steps at once");
  list.Add("covisibility_filter",
           &covisibility_filter,
           "keeps only neighbours and matches that keyframes see together");
  list.Add("max_matches", &max_matches, Range(4, 100000), "matches after which the search ends");
  list.Add("num_tree_checks",
           &num_tree_checks,
           Range(1, 1e6),
           "descriptors compared per feature with search = tree");
  list.Add("max_descriptor_distance",
           &max_descriptor_distance,
           Range(0, 2),
           "largest descriptor distance of a match; 1: as unrelated descriptors");
  list.Add("max_focal_ratio",
           &max_focal_ratio,
           Range(1, 1000),
           "largest ratio of a picture's focal length to the map's, in px; finer pictures are "
           "scaled down to the map's");
  list.Add("solver", &solver, {"p3p", "dlt6"}, "solver for RANSAC samples of 3 matches, or of 6");
  list.Add("local_optimization", &local_optimization, "optimizes each best sample of RANSAC");
  list.Add("refinement", &refinement, "refines the pose by robust least squares over the inliers");
  list.Add(
      "readout_turn_sigma_rad",
      &readout_turn_sigma_rad,
      Range(0, 1),
      "expected rotation of the camera from a picture's first row to its last; 0: global shutter");
  list.Add("readout_shift_sigma_m",
           &readout_shift_sigma_m,
           Range(1e-6, 1),
           "expected distance that the camera moves in that time");
  list.Add(
      "max_error_px", &max_error_px, Range(0.5, 50), "largest reprojection error of an inlier");
  list.Add("max_iterations", &max_iterations, Range(10, 1e6), "RANSAC iterations");
  list.Add("min_seed_inliers",
           &min_seed_inliers,
           Range(4, 1000),
           "smallest number of inliers of the first pose");
  list.Add("num_retrieved_keyframes",
           &num_retrieved_keyframes,
           Range(0, 1000),
           "keyframes to search when the words gave no pose; 0: none");
  list.Add("num_guided_keyframes",
           &num_guided_keyframes,
           Range(0, 1000),
           "keyframes whose landmarks are projected with the first pose; 0: no second search");
  list.Add("guided_radius_px",
           &guided_radius_px,
           Range(1, 100),
           "search radius around landmarks projected with the first pose");
  list.Add("min_inliers",
           &min_inliers,
           Range(4, 1000),
           "smallest number of inliers of the final pose; fewer: not in the map");
  list.Add(
      "min_inlier_significance",
      &min_inlier_significance,
      Range(0, 1000),
      "smallest excess of inliers over a wrong pose, in standard deviations; less: not in the map");
  list.Add("max_position_sigma_m",
           &max_position_sigma_m,
           Range(0.001, 1000),
           "largest standard deviation of the position; more: not in the map");
  list.Add("rival_distance_m",
           &rival_distance_m,
           Range(0.01, 1000),
           "landmarks, and poses, at least this far apart are different places");
  list.Add("max_rival_ratio",
           &max_rival_ratio,
           Range(0, 1),
           "largest share of inliers in another place; more: the features vote; 1: does not search "
           "for other places");
  list.Add("min_rival_significance",
           &min_rival_significance,
           Range(0, 1000),
           "smallest lead in the vote, in standard deviations; less: ambiguous");
  list.Add("seed", &seed, Range(0, 2e9), "seed of RANSAC");
}

std::vector<QueryResult> RunLocalize(const LocalizeOptions& options,
                                     const LocalizeInput& input,
                                     Progress& progress,
                                     int num_threads) {
  constexpr std::size_t kBatch = 256;  // bounds the memory for features
  CheckInput(input);
  const Localizer localizer(options, *input.map, *input.vocabulary);
  std::vector<QueryResult> results;
  progress.Start(2 * input.queries.size());
  for (std::size_t begin = 0; begin < input.queries.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, input.queries.size() - begin);
    const std::span queries(&input.queries[begin], count);
    for (LocatedPicture& located :
         LocateBatch(options, input, localizer, queries, progress, num_threads)) {
      if (!located.problem.empty()) input.skip(located.problem);
      results.push_back(std::move(located.result));
    }
  }
  progress.Finish();
  return results;
}

}  // namespace nightmap
