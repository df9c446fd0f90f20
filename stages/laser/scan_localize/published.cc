// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/published.h"

#include "pipeline/laser/match_scan.h"
#include "stages/laser/scan_localize/boundary_refine.h"
#include "stages/laser/scan_localize/candidate_scores.h"
#include "stages/laser/scan_localize/object_evidence.h"

namespace nightmap {

PublishedPlaces FindCandidatesAsPublished(const PublishedOptions& options,
                                          const CandidateOptions& candidate_options,
                                          const ScanMap& map,
                                          const std::vector<MapObject>& objects,
                                          const ScanQuery& query) {
  const auto points = PointsInQuery(query, candidate_options.max_range_m);
  const auto fine_points = FinePoints(candidate_options, map, points);
  const ObjectScene scene{map.Grid(), query, candidate_options.max_range_m};
  const auto near = ObjectsNear(options.filter, scene, objects);
  const auto found = SearchTemplate(options.search, map, query);
  PublishedPlaces places;
  places.num_near_objects = near.size();
  const auto poses = PosesByObjects(options.filter, scene, near, found);
  const auto matches = FilterByPoses(options.filter, scene, near, poses, found);
  places.object_poses = PosesApart(poses);
  places.num_filtered = found.size() - matches.size();
  const auto walls_of_objects = WallsOfObjects(map.Grid(), objects);
  std::vector<ScanCandidate> candidates;
  for (const TemplateMatch& match : matches) {
    const Rigid2 refined =
        RefineOnBoundary(map, fine_points, match.map_from_query, options.refine_gate_m);
    ScanCandidate candidate;
    candidate.map_from_query = refined;
    candidate.covariance = RefineFound(map, fine_points, map.FieldFrom(refined)).covariance;
    candidate.search_score = match.score;
    candidate.score = ScoreOf(map.FineField(), fine_points, map.FieldFrom(refined));
    ScoreCandidate(candidate_options, map, walls_of_objects, query, &candidate);
    candidate.fit = FitByEvidence(candidate.walls_fit, candidate.objects);
    candidates.push_back(candidate);
  }
  places.candidates = BestOfPlaces(std::move(candidates));
  return places;
}

}  // namespace nightmap
