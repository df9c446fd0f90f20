// SPDX-License-Identifier: Apache-2.0
// Parts of a drive: the submaps that loops are looked for in, and the stretches that are looked
// for.
#pragma once

#include <vector>

#include "pipeline/laser/likelihood_field.h"
#include "stages/laser/scan_loops/drive.h"
#include "stages/laser/scan_loops/scan_loops.h"

namespace nightmap {

// Keyscans [first, end), as the one in their middle sees them.
struct ScanStretch {
  std::size_t first = 0;
  std::size_t middle = 0;
  std::size_t end = 0;
};

// Stretches of submap_length_m of path, each half a length after the one before.
std::vector<ScanStretch> CutSubmaps(const ScanLoopsOptions& options,
                                    const std::vector<Keyscan>& keyscans);

// Stretches of query_length_m about a keyscan every metre of path.
std::vector<ScanStretch> CutQueries(const ScanLoopsOptions& options,
                                    const std::vector<Keyscan>& keyscans);

// All points of a stretch, metres in the frame of the robot at its middle, and the normals of their
// walls.
struct StretchPoints {
  std::vector<Eigen::Vector2d> points, normals;
};
StretchPoints PointsOf(const std::vector<Keyscan>& keyscans, const ScanStretch& stretch);

// The submap that a query may be in, for each: (index of the submap, index of the query),
// ascending. The drift between them lets the query be within max_distance_m of the submap's middle,
// and min_path_m of path lie between. A query has at most max_candidates, the nearest first, and
// one of submaps that overlap. Where the drift is unknown, every kUnknownSpacing-th query is looked
// for in all submaps of which none overlap. Otherwise the submaps
// around the query are looked at, and not those of the whole drive.
inline constexpr std::size_t kUnknownSpacing = 4;
struct LoopPair {
  std::size_t submap = 0;
  std::size_t query = 0;
  Drift drift;
};
std::vector<LoopPair> PairsToTry(const ScanLoopsOptions& options,
                                 const std::vector<Keyscan>& keyscans,
                                 const DriftSums& drifts,
                                 const std::vector<ScanStretch>& submaps,
                                 const std::vector<ScanStretch>& queries);

}  // namespace nightmap
