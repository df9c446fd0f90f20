// SPDX-License-Identifier: Apache-2.0
// Laser relocalization as published (CN110307838A): objects filter what template matching finds.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/laser/scan_queries_io.h"
#include "pipeline/plan/objects_io.h"
#include "stages/laser/scan_localize/object_filter.h"
#include "stages/laser/scan_localize/scan_candidates.h"
#include "stages/laser/scan_localize/scan_map.h"
#include "stages/laser/scan_localize/template_search.h"

namespace nightmap {

struct PublishedOptions {
  OPTIONS_OF(TemplateOptions, search);
  OPTIONS_OF(ObjectFilterOptions, filter);
  OPTION(double, refine_gate_m, 0.5, {0.01, 10},
         "points as near as this to a wall take part in the refinement");
  REGISTER_OPTIONS();
};

struct PublishedPlaces {
  std::vector<ScanCandidate> candidates;
  std::vector<ObjectPose> object_poses;  // the second list, thinned
  std::size_t num_near_objects = 0;
  std::size_t num_filtered = 0;  // places that the filter removed
};

// The places of the template search (template_search.h) that agree with the objects near the rough
// position (object_filter.h), refined on the boundary (boundary_refine.h). The best fit first, no
// two at the same place. Scores are those of FindCandidates, but search_score is the similarity of
// the pictures. Empty also when the objects contradict all places. Deterministic if OpenCV runs on
// one thread. The fit weighs objects by their evidence (object_evidence.h).
PublishedPlaces FindCandidatesAsPublished(const PublishedOptions& options,
                                          const CandidateOptions& candidate_options,
                                          const ScanMap& map,
                                          const std::vector<MapObject>& objects,
                                          const ScanQuery& query);

}  // namespace nightmap
