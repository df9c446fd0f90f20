// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/candidate_scores.h"

#include <algorithm>
#include <cmath>

#include "pipeline/laser/thin_points.h"
#include "pipeline/plan/cell_walk.h"

namespace nightmap {
namespace {

// Error that the search may leave to the refinement.
constexpr double kRefineSigma_m = 0.3;
constexpr double kRefineSigma_rad = 0.1;
constexpr double kBeforeEnd_m = 0.4;  // a wall so near to the end of a beam is what it hit
// The coarse field forgives what the fine one does not; together they tell places apart best.
constexpr double kFineWeight = 0.6;
// Objects say more than other walls, since they cannot have changed.
constexpr double kObjectWeight = 0.3;
constexpr double kObjectWalls = 20;  // as many walls of objects weigh half of that
constexpr double kOnWall_m = 0.1;

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

std::vector<bool> OnWall(const ScanMap& map,
                         const std::vector<Eigen::Vector2d>& points,
                         const Rigid2& map_from_query) {
  std::vector<bool> on_wall;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2i cell = map.Grid().CellOf(map_from_query * point);
    on_wall.push_back(map.Grid().Contains(cell) && map.WallDistance_m(cell) <= kOnWall_m);
  }
  return on_wall;
}

// The heading (rad^2) errs by what the grid does to walls: each stands at the centre of its cell.
double GridTurnVariance(double cell_m, const std::vector<Eigen::Vector2d>& points) {
  double sum_m2 = cell_m * cell_m;
  for (const Eigen::Vector2d& point : points) sum_m2 += point.squaredNorm();
  const double mean_m2 = sum_m2 / static_cast<double>(points.size() + 1);
  return cell_m * cell_m / 12 / mean_m2;
}

}  // namespace

ScanMatch RefineFound(const ScanMap& map,
                      const std::vector<Eigen::Vector2d>& fine_points,
                      const Rigid2& field_from_query) {
  const PosePrior prior{field_from_query, kRefineSigma_m, kRefineSigma_rad};
  ScanMatch match = RefinePose(map.FineField(), fine_points, prior, field_from_query);
  match.covariance(2, 2) += GridTurnVariance(map.Grid().resolution_m, fine_points);
  return match;
}

std::vector<Eigen::Vector2d> FinePoints(const CandidateOptions& options,
                                        const ScanMap& map,
                                        const std::vector<Eigen::Vector2d>& points) {
  return SpreadPoints(ThinPoints(points, map.Grid().resolution_m),
                      static_cast<std::size_t>(options.max_points));
}

void ScoreCandidate(const CandidateOptions& options,
                    const ScanMap& map,
                    const std::vector<Eigen::Vector2d>& walls_of_objects,
                    const ScanQuery& query,
                    ScanCandidate* candidate) {
  const Rigid2& pose = candidate->map_from_query;
  candidate->through_share = ThroughShare(options, map.Grid(), query, pose);
  candidate->objects = ViewObjects(walls_of_objects, query, pose, options.max_range_m);
  const auto points = FinePoints(options, map, PointsInQuery(query, options.max_range_m));
  candidate->on_wall = OnWall(map, points, pose);
  candidate->walls_fit =
      kFineWeight * candidate->score + (1 - kFineWeight) * candidate->search_score;
  candidate->fit = FitWithObjects(candidate->walls_fit, candidate->objects);
}

std::vector<ScanCandidate> BestOfPlaces(std::vector<ScanCandidate> candidates) {
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
