// SPDX-License-Identifier: Apache-2.0
// Loops that another submap casts doubt on.
#pragma once

#include <vector>

#include "stages/laser/scan_loops/drive.h"
#include "stages/laser/scan_loops/scan_loops.h"

namespace nightmap {

// A place that repeats itself, as along a corridor with doors, may be found at the rim of a submap
// in which nothing else looks like it. So what all submaps say of a query counts. A loop is none
// when another submap scores nearly as much (max_second_ratio) and finds several places, or scores
// clearly more and finds the query farther off than the drift between both submaps allows. Decides
// by the candidates as they are; then changes is_loop.
void DropDoubtfulLoops(const ScanLoopsOptions& options,
                       const std::vector<Keyscan>& keyscans,
                       const DriftSums& drifts,
                       std::vector<ScanLoopCandidate>* candidates);

}  // namespace nightmap
