// SPDX-License-Identifier: Apache-2.0
// PCL's iterative closest points and voxel filter, on points in the plane.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "stages/laser/scan_localize/object_filter.h"

namespace nightmap {

// The mean of the points in each cell of a lattice.
std::vector<Eigen::Vector2d> FilterByVoxels(const std::vector<Eigen::Vector2d>& points,
                                            double voxel_m);

// Matches the cloud of a submap to the walls of an object, at least one, from each start. Keeps the
// poses map_from_query at which it converged.
std::vector<Rigid2> MatchToObject(const ObjectFilterOptions& options,
                                  const std::vector<Eigen::Vector2d>& walls_in_map,
                                  const std::vector<Eigen::Vector2d>& points_in_query,
                                  const std::vector<Rigid2>& starts);

}  // namespace nightmap
