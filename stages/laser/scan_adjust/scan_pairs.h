// SPDX-License-Identifier: Apache-2.0
// Pairs of scans that are compared.
#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "stages/laser/scan_adjust/scan_adjust.h"

namespace nightmap {

struct ScanPair {
  std::size_t scan = 0;    // its points
  std::size_t target = 0;  // lie on this one's walls
};

// Chooses for each keyscan some of those shortly before it, at growing distances, and the nearest
// ones of other times, which are at least kOtherTime_m of path away. Nearest by place and heading.
inline constexpr double kOtherTime_m = 5;
std::vector<ScanPair> ChoosePairs(const ScanAdjustOptions& options,
                                  const std::vector<Rigid2>& graph_from_robot);

}  // namespace nightmap
