// SPDX-License-Identifier: Apache-2.0
// How well a place explains a scan, whichever method found the place.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/laser/match_scan.h"
#include "stages/laser/scan_localize/scan_candidates.h"

namespace nightmap {

// At most max_points of the points, one per cell of the grid: the fine score is their mean.
std::vector<Eigen::Vector2d> FinePoints(const CandidateOptions& options,
                                        const ScanMap& map,
                                        const std::vector<Eigen::Vector2d>& points);

// The most likely pose near one that a search found, by at most max_points of the points, with its
// covariance. Pure.
ScanMatch RefineFound(const ScanMap& map,
                      const std::vector<Eigen::Vector2d>& fine_points,
                      const Rigid2& field_from_query);

// Fills through_share, objects, on_wall, walls_fit and fit from the pose and both scores. Pure.
void ScoreCandidate(const CandidateOptions& options,
                    const ScanMap& map,
                    const std::vector<Eigen::Vector2d>& walls_of_objects,
                    const ScanQuery& query,
                    ScanCandidate* candidate);

// The best fit first; of several candidates at one place (IsSamePlace) the best stays.
std::vector<ScanCandidate> BestOfPlaces(std::vector<ScanCandidate> candidates);

}  // namespace nightmap
