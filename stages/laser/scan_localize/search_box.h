// SPDX-License-Identifier: Apache-2.0
// Where in the map the robot of a query can be.
#pragma once

#include <Eigen/Core>

#include "pipeline/laser/scan_queries_io.h"
#include "stages/laser/scan_localize/scan_map.h"

namespace nightmap {

// Along the axes of the map, in m.
struct SearchBox {
  Eigen::Vector2d low, high;
};

// Holds the rough position or, where there is none, the whole grid.
SearchBox BoxOf(const ScanMap& map, const ScanQuery& query);

// Whether a point lies within the rough position, and free cells are near it.
bool CanBeAt(const ScanMap& map, const ScanQuery& query, const Eigen::Vector2d& point_in_map);

}  // namespace nightmap
