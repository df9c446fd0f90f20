// SPDX-License-Identifier: Apache-2.0
// localize: where was each query picture taken? Only the picture is used, never its depth.
#pragma once

#include <functional>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/landmarks_io.h"
#include "pipeline/io/queries_io.h"
#include "pipeline/vision/extract_features.h"
#include "pipeline/vision/vocabulary_io.h"

namespace nightmap {

struct LocalizeOptions {
  int search_level = 3;
  double max_ratio = 0.8;
  double same_point_radius_m = 0.1;
  int max_matches = 300;
  int num_retrieved_keyframes = 5;
  int num_guided_keyframes = 10;
  double guided_radius_px = 10.0;
  double max_descriptor_distance = 0.7;
  double max_error_px = 4.0;
  int max_iterations = 2000;
  int min_seed_inliers = 8;
  int min_inliers = 12;
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
};

// One result a query, in their order; a query that fails has the reason: unreadable_image,
// no_features, too_few_matches, too_few_inliers. Deterministic in the seed, at any number of
// threads. Throws DataError without queries or landmarks or when map and vocabulary do not belong
// together.
std::vector<QueryResult> RunLocalize(const LocalizeOptions& options,
                                     const LocalizeInput& input,
                                     Progress& progress,
                                     int num_threads);

}  // namespace nightmap
