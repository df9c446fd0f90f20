// SPDX-License-Identifier: Apache-2.0
// Places of the map at which a scan may have been taken, and how well each explains it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/laser/scan_queries_io.h"
#include "stages/laser/scan_localize/object_views.h"
#include "stages/laser/scan_localize/scan_map.h"

namespace nightmap {

struct CandidateOptions {
  OPTION(double, max_range_m, 30, {1, 500}, "points farther away are not used");
  OPTION(int, max_points, 180, {10, 10000}, "points that the final pose is found by");
  OPTION(double, min_share_of_best, 0.75, {0.1, 1},
         "places with a smaller share of the best score are no candidates");
  OPTION(int, max_candidates, 60, {2, 1000}, "of a query; the best by search score");
  REGISTER_OPTIONS();
};

struct ScanCandidate {
  Rigid2 map_from_query;
  double search_score = 0;   // mean of the search field at the points, 0 .. 1
  double score = 0;          // mean of the fine field at the points, 0 .. 1
  double through_share = 0;  // of the beams that pass a wall before they end
  ObjectView objects;
  double walls_fit = 0;       // how well the place explains the scan, 0 .. 1: both scores
  double fit = 0;             // the same with the objects, which weigh more than other walls
  std::vector<bool> on_wall;  // of the points: whether a wall of the map is within 0.1 m
  // Covariance of x, y (m) in the map and of the heading (rad).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

inline constexpr double kSamePlace_m = 0.5;
// The same place: nearer than this and 0.2 rad.
bool IsSamePlace(const Rigid2& a, const Rigid2& b, double radius_m = kSamePlace_m);

// All places of the map, or within the query's rough position, whose search score is at least
// min_share_of_best (near a rough position 0.6) of the largest, refined; the best fit
// first, no two at the same place. The search is by branch and bound and misses nothing
// (search_pose.h). The final pose is the most likely one when points far from all walls count
// alike, however far (match_scan.h): so furniture that came or went does not drag it.
// `walls_of_objects` in the map; empty: there are no objects. Pure.
std::vector<ScanCandidate> FindCandidates(const CandidateOptions& options,
                                          const ScanMap& map,
                                          const std::vector<Eigen::Vector2d>& walls_of_objects,
                                          const ScanQuery& query);

}  // namespace nightmap
