// SPDX-License-Identifier: Apache-2.0
// Keyscans: the scans that stand for a drive, with a pose each and edges from one to the next.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

// Points that the scan of keyscan `i` hit up to max_range_m away, metres in the x-y plane of the
// robot at the scan's time, in the order of the beams. `keyscans` are poses of the robot; the
// motion over a scan is that towards the next one. Throws InputError of the ports `keyframes` and
// `scans` when there is no scan at the keyscan's time. Pure.
std::vector<Eigen::Vector2d> PointsOfKeyscan(const Signal& scans,
                                             const std::vector<StampedPose>& keyscans,
                                             std::size_t i,
                                             double max_range_m);

// Throws InputError of the ports `odometry` and `keyframes` unless edge i leads from keyscan i to
// the next one, and there is a keyscan.
void CheckEdgesOfKeyscans(const std::vector<StampedPose>& keyscans,
                          const std::vector<SensorEdge>& edges);

}  // namespace nightmap
