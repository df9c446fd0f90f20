// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/scan_candidates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/laser/match_scan.h"
#include "pipeline/laser/search_pose.h"
#include "pipeline/laser/thin_points.h"
#include "stages/laser/scan_localize/candidate_scores.h"

namespace nightmap {
namespace {

constexpr int kMaxSearchPoints = 100;  // points of a scan that the map is searched for
// Within a rough position, where candidates cost little, in the place of min_share_of_best.
constexpr double kMinShareNearby = 0.6;
constexpr double kSamePlace_rad = 0.2;
constexpr double kMinSearchScore = 0.1;

SearchWindow WindowOf(const ScanMap& map, const ScanQuery& query) {
  SearchWindow window;
  window.half_extent_m = map.HalfExtent_m();
  window.half_angle_rad = std::numbers::pi;
  window.min_value = kMinSearchScore;
  window.places = &map.Places();
  if (query.rough_position) {
    window.center.translation = map.ToField(query.rough_position->point_in_map);
    window.half_extent_m = query.rough_position->radius_m;
  }
  return window;
}

std::vector<FoundPose> SearchPlaces(const CandidateOptions& options,
                                    const ScanMap& map,
                                    const ScanQuery& query,
                                    const std::vector<Eigen::Vector2d>& points) {
  const double cell_m = map.SearchPyramid().Field().Resolution_m();
  const auto few =
      SpreadPoints(ThinPoints(points, cell_m), static_cast<std::size_t>(kMaxSearchPoints));
  const double min_share = query.rough_position ? kMinShareNearby : options.min_share_of_best;
  std::vector<FoundPose> places;
  for (const FoundPose& pose :
       SearchPoses(map.SearchPyramid(), few, WindowOf(map, query), min_share)) {
    const auto is_same = [&](const FoundPose& other) {
      return IsSamePlace(pose.field_from_robot, other.field_from_robot);
    };
    if (std::ranges::none_of(places, is_same)) places.push_back(pose);
    if (places.size() == static_cast<std::size_t>(options.max_candidates)) break;
  }
  return places;
}

}  // namespace

bool IsSamePlace(const Rigid2& a, const Rigid2& b, double radius_m) {
  return (a.translation - b.translation).norm() <= radius_m &&
         std::abs(WrapAngle_rad(a.heading_rad - b.heading_rad)) <= kSamePlace_rad;
}

std::vector<ScanCandidate> FindCandidates(const CandidateOptions& options,
                                          const ScanMap& map,
                                          const std::vector<Eigen::Vector2d>& walls_of_objects,
                                          const ScanQuery& query) {
  const auto points = PointsInQuery(query, options.max_range_m);
  const auto fine_points = FinePoints(options, map, points);
  std::vector<ScanCandidate> candidates;
  for (const FoundPose& place : SearchPlaces(options, map, query, points)) {
    const ScanMatch match = RefineFound(map, fine_points, place.field_from_robot);
    ScanCandidate candidate;
    candidate.map_from_query = map.ToMap(match.field_from_robot);
    candidate.search_score = place.score;
    candidate.score = match.score;
    candidate.covariance = match.covariance;
    ScoreCandidate(options, map, walls_of_objects, query, &candidate);
    candidates.push_back(candidate);
  }
  return BestOfPlaces(std::move(candidates));
}

}  // namespace nightmap
