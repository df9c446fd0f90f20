// SPDX-License-Identifier: Apache-2.0
#include "stages/scan_localize/scan_candidates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/planar/cell_walk.h"
#include "pipeline/planar/match_scan.h"
#include "pipeline/planar/search_pose.h"
#include "pipeline/planar/thin_points.h"

namespace nightmap {
namespace {

constexpr double kSamePlace_m = 0.5;
constexpr double kSamePlace_rad = 0.2;
// What the search may leave to the refinement.
constexpr double kRefineSigma_m = 0.3;
constexpr double kRefineSigma_rad = 0.1;
constexpr double kBeforeEnd_m = 0.4;  // a wall so near to the end of a beam is what it hit
constexpr double kMinSearchScore = 0.1;
// The coarse field forgives what the fine one does not; together they tell places apart best.
constexpr double kFineWeight = 0.6;
// Objects say more than other walls, since they cannot have changed.
constexpr double kObjectWeight = 0.3;
constexpr double kObjectWalls = 20;  // as many walls of objects weigh half of that

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
      SpreadPoints(ThinPoints(points, cell_m), static_cast<std::size_t>(options.max_search_points));
  std::vector<FoundPose> places;
  for (const FoundPose& pose :
       SearchPoses(map.SearchPyramid(), few, WindowOf(map, query), options.min_share_of_best)) {
    const auto is_same = [&](const FoundPose& other) {
      return IsSamePlace(pose.field_from_robot, other.field_from_robot);
    };
    if (std::ranges::none_of(places, is_same)) places.push_back(pose);
    if (places.size() == static_cast<std::size_t>(options.max_candidates)) break;
  }
  return places;
}

// Whether a wall stands on the way from `from` to `to`, points in the map.
bool IsBlocked(const OccupancyGrid& grid, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  bool is_blocked = false;
  WalkCells(grid.ToCells(from), grid.ToCells(to), [&](const Eigen::Vector2i& cell) {
    is_blocked = is_blocked || (grid.Contains(cell) && grid.At(cell) == kOccupiedCell);
  });
  return is_blocked;
}

// The share of the beams, at most max_points of them, that pass a wall.
double ThroughShare(const CandidateOptions& options,
                    const OccupancyGrid& grid,
                    const ScanQuery& query,
                    const Rigid2& map_from_query) {
  std::size_t num_beams = 0;
  for (const QueryScan& scan : query.scans) num_beams += scan.ranges_m.size();
  const std::size_t step = 1 + num_beams / static_cast<std::size_t>(options.max_points + 1);
  int num_through = 0, num_hits = 0;
  for (const QueryScan& scan : query.scans) {
    const Rigid2 map_from_laser = map_from_query * scan.query_from_laser;
    for (std::size_t i = 0; i < scan.ranges_m.size(); i += step) {
      if (!scan.IsHit(i) || scan.ranges_m[i] > options.max_range_m) continue;
      const Eigen::Vector2d beam(std::cos(scan.Angle_rad(i)), std::sin(scan.Angle_rad(i)));
      const double before_m = std::max(0.0, scan.ranges_m[i] - kBeforeEnd_m);
      num_through +=
          IsBlocked(grid, map_from_laser.translation, map_from_laser * (before_m * beam));
      ++num_hits;
    }
  }
  return static_cast<double>(num_through) / std::max(1, num_hits);
}

// The fit of the walls and what the scan says of the objects.
double FitWithObjects(double walls_fit, const ObjectView& objects) {
  const double num_seen = objects.num_confirmed + objects.num_contradicted;
  if (num_seen == 0) return walls_fit;
  const double weight = kObjectWeight * num_seen / (num_seen + kObjectWalls);
  return (1 - weight) * walls_fit + weight * objects.num_confirmed / num_seen;
}

// The heading (rad^2) errs by what the grid does to walls: each stands at the centre of its cell.
double GridTurnVariance(double cell_m, const std::vector<Eigen::Vector2d>& points) {
  double sum_m2 = cell_m * cell_m;
  for (const Eigen::Vector2d& point : points) sum_m2 += point.squaredNorm();
  const double mean_m2 = sum_m2 / static_cast<double>(points.size() + 1);
  return cell_m * cell_m / 12 / mean_m2;
}

}  // namespace

void CandidateOptions::Register(OptionList& list) {
  list.Add("max_range_m", &max_range_m, Range(1, 500), "points farther away are not used");
  list.Add("max_search_points",
           &max_search_points,
           Range(10, 10000),
           "points of a scan that the map is searched for");
  list.Add("max_points", &max_points, Range(10, 10000), "points that the final pose is found by");
  list.Add("min_share_of_best",
           &min_share_of_best,
           Range(0.1, 1),
           "places with a smaller share of the best score are no candidates");
  list.Add(
      "max_candidates", &max_candidates, Range(2, 1000), "of a query; the best by search score");
}

bool IsSamePlace(const Rigid2& a, const Rigid2& b) {
  return (a.translation - b.translation).norm() <= kSamePlace_m &&
         std::abs(WrapAngle_rad(a.heading_rad - b.heading_rad)) <= kSamePlace_rad;
}

std::vector<ScanCandidate> FindCandidates(const CandidateOptions& options,
                                          const ScanMap& map,
                                          const std::vector<Eigen::Vector2d>& walls_of_objects,
                                          const ScanQuery& query) {
  const auto points = PointsInQuery(query, options.max_range_m);
  const auto fine_points = SpreadPoints(ThinPoints(points, map.Grid().resolution_m),
                                        static_cast<std::size_t>(options.max_points));
  std::vector<ScanCandidate> candidates;
  for (const FoundPose& place : SearchPlaces(options, map, query, points)) {
    const PosePrior prior{place.field_from_robot, kRefineSigma_m, kRefineSigma_rad};
    const ScanMatch match = RefinePose(map.FineField(), fine_points, prior, place.field_from_robot);
    ScanCandidate candidate;
    candidate.map_from_query = map.ToMap(match.field_from_robot);
    candidate.search_score = place.score;
    candidate.score = match.score;
    candidate.covariance = match.covariance;
    candidate.covariance(2, 2) += GridTurnVariance(map.Grid().resolution_m, fine_points);
    candidate.through_share = ThroughShare(options, map.Grid(), query, candidate.map_from_query);
    candidate.objects =
        ViewObjects(walls_of_objects, query, candidate.map_from_query, options.max_range_m);
    candidate.walls_fit = kFineWeight * match.score + (1 - kFineWeight) * place.score;
    candidate.fit = FitWithObjects(candidate.walls_fit, candidate.objects);
    candidates.push_back(candidate);
  }
  std::ranges::stable_sort(candidates, std::greater(), &ScanCandidate::fit);
  std::vector<ScanCandidate> apart;
  for (const ScanCandidate& candidate : candidates) {
    const auto is_same = [&](const ScanCandidate& other) {
      return IsSamePlace(candidate.map_from_query, other.map_from_query);
    };
    if (std::ranges::none_of(apart, is_same)) apart.push_back(candidate);
  }
  return apart;
}

}  // namespace nightmap
