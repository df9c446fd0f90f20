// SPDX-License-Identifier: Apache-2.0
// Keyframes that see a thing.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/dense/tiles_io.h"
#include "pipeline/io/things_io.h"
#include "stages/labels/things/labelled_space.h"

namespace nightmap {

struct ThingViews {
  int num_views = 0;
  std::optional<ThingView> best;
  // Mean direction, seen from above, from the thing to the cameras that see it; 0 without views.
  Eigen::Vector2d direction_in_map = Eigen::Vector2d::Zero();
};

// A keyframe sees a thing when it sees a quarter of its points (of 64 of them, if there are more):
// they lie in the picture, within the range, and nothing is occupied before them up to 1.5 voxels.
// The best view has the largest share of points seen, times the area of the rectangle around the
// thing in the picture; of equals the first keyframe. Throws DataError when a keyframe has no
// camera.
ThingViews FindViews(const LabelledSpace& space,
                     const std::vector<Eigen::Vector3d>& points_in_map,
                     const std::vector<Keyframe>& keyframes,
                     const std::vector<RgbdCamera>& cameras,
                     double max_range_m);

}  // namespace nightmap
