// SPDX-License-Identifier: Apache-2.0
// Chooses which corners of a frame begin new tracks.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/camera.h"

namespace nightmap {

struct NewCornerOptions {
  OPTION(int, min_tracks, 60, {0, 10000},
         "corners are taken anew from a frame when fewer tracks are left");
  OPTION(int, max_tracks, 120, {1, 10000}, "then up to this number of tracks");
  OPTION(double, min_distance_px, 12, {3, 200}, "smallest distance of a new corner from any track");
  REGISTER_OPTIONS();
};

// Indices into `corners` (raw pixels, strongest first), ascending. The strongest corner of each of
// 8 x 6 cells of the picture without a track; when fewer than min_tracks are left, then the
// strongest corners of the cells with fewest tracks, up to max_tracks. None is nearer than
// min_distance_px to a track or to another new corner.
std::vector<int> ChooseNewCorners(const std::vector<Eigen::Vector2f>& corners,
                                  const std::vector<Eigen::Vector2f>& tracks,
                                  const Camera& camera,
                                  const NewCornerOptions& options);

}  // namespace nightmap
