// SPDX-License-Identifier: Apache-2.0
// Joint refinement of the poses and points of one shard.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"
#include "stages/odometry/initial_poses.h"
#include "stages/odometry/odometry.h"

namespace nightmap {

struct ShardBundle {
  std::vector<Track> tracks;  // sightings the adjustment agreed with; it may leave a track none
  std::vector<Eigen::Vector3d> points_in_shard;  // one a track
  std::vector<BundleSummary> adjustments;        // in order
  int num_unrefined = 0;  // tracked frames that keep their chained pose: too few points fit another
};

// Joins the accepted pairs to tracks, adjusts the described frames and the points that at least two
// of them see, drops observations off by more than max_error_px and adjusts again. Tracked frames
// then get the pose that fits the points best. Updates the poses in `frames` (frame i is
// input.frames[i]). Throws DataError when an adjustment fails.
[[nodiscard]] ShardBundle AdjustShard(const OdometryOptions& options,
                                      const OdometryInput& input,
                                      std::vector<ChainedFrame>* frames);

}  // namespace nightmap
