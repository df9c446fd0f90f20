// SPDX-License-Identifier: Apache-2.0
// Where the picture of a submap is alike the picture of the map: template matching at many headings
// (publication CN110307838A, S104).
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/laser/scan_queries_io.h"
#include "stages/laser/scan_localize/scan_map.h"

namespace nightmap {

struct TemplateOptions {
  OPTION(int, num_angles, 120, {4, 3600}, "headings of the submap");
  double resolution_m = 0.1;  // pixels of the finest level of the pyramid
  OPTION(int, num_levels, 2, {1, 6}, "of the pyramid");
  double max_range_m = 15;  // the picture of the submap ends at this distance from the laser
  // Places with a smaller share of the best similarity are no candidates.
  double min_share_of_best = 0.4;
  int max_candidates = 40;  // places that the pyramid follows; the most similar
  OPTION(double, suppression_radius_m, 0.5, {0, 10},
         "of places so near to each other, at about one heading, the most similar stays");
  REGISTER_OPTIONS();
};

struct TemplateMatch {
  Rigid2 map_from_query;
  double score = 0;  // 0 .. 1
};

// Places where a robot can be, in the whole map or within the query's rough position; the best
// first, no two within the suppression radius at about one heading. The coarsest level of the
// pyramid, whose pixels are 2^(num_levels - 1) times as large, is matched everywhere at num_angles
// headings; its maxima are followed to the finest level, with half the step of the heading each.
// Only pixels that the submap saw count. Not exhaustive: what the coarsest level does not show is
// missed. Deterministic if OpenCV runs on one thread.
std::vector<TemplateMatch> SearchTemplate(const TemplateOptions& options,
                                          const ScanMap& map,
                                          const ScanQuery& query);

}  // namespace nightmap
