// SPDX-License-Identifier: Apache-2.0
// Whether the best of the candidates is where the robot is.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/io/queries_io.h"
#include "stages/laser/scan_localize/scan_candidates.h"

namespace nightmap {

struct VerdictOptions {
  OPTION(int, min_points, 20, {3, 10000}, "fewer points show nothing recognizable");
  OPTION(double, min_agreement, 0.55, {-1, 1},
         "surely in the map: fine score less the share of the beams that pass walls");
  OPTION(double, max_unique_ratio, 0.88, {0, 1},
         "in the map, if changed: no other place fits better than this times the best");
  OPTION(double, max_rival_ratio, 0.95, {0, 1},
         "ambiguous: another place fits better than this times the best");
  OPTION(double, min_lead_share, 0.05, {0, 1},
         "ambiguous: a place that is not unique explains less than this of the points more");
  OPTION(double, max_position_sigma_m, 0.5, {0.001, 100},
         "ambiguous: the place leaves the position more uncertain than this");
  REGISTER_OPTIONS();
};

// A verdict and, unless located, its reason: too_few_points (no_features), poor_fit, not_alike (not
// in the map), uncertain_pose, rival_place (ambiguous).
struct ScanVerdict {
  QueryVerdict verdict = QueryVerdict::kNotInMap;
  const char* reason = "";
};

// `candidates` as FindCandidates gives them. A scan is in the map when its best place explains it:
// the fine score less the share of the beams that pass walls, which is the agreement, is high. In a
// building that changed much, no place does; then the best one counts if no other comes near it,
// because in another building many places fit about as badly. Where the robot is known to be
// nearby, the objects take part in this: a place that they confirm is in the map. A place is
// ambiguous when another one fits about as well, or explains about the same points and the objects
// do not tell them apart. `are_objects_weighed` says that the fit has all that objects tell of two
// places already (object_evidence.h); then they decide nothing beside it, but a place that they
// speak against is none.
ScanVerdict Judge(const VerdictOptions& options,
                  const ScanQuery& query,
                  std::size_t num_points,
                  const std::vector<ScanCandidate>& candidates,
                  bool are_objects_weighed);

}  // namespace nightmap
