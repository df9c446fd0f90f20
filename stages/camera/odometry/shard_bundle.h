// SPDX-License-Identifier: Apache-2.0
// Joint refinement of a shard's poses and points.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"
#include "stages/camera/odometry/initial_poses.h"
#include "stages/camera/odometry/odometry.h"

namespace nightmap {

struct ShardBundle {
  // Observations that the adjustment agreed with; a track may have none left.
  std::vector<Track> tracks;
  std::vector<Eigen::Vector3d> points_in_shard;  // one per track
  std::vector<BundleSummary> adjustments;        // in order
  // Tracked frames that keep their chained pose, because too few points fit another.
  int num_unrefined = 0;
};

// Joins the accepted pairs to tracks, adjusts the described frames and the points that at least two
// of them see, drops observations off by more than max_error_px and adjusts again. Then gives each
// tracked frame the pose that fits the points best. Updates the poses in `frames` (frame i is
// input.frames[i]). Throws DataError when an adjustment fails.
[[nodiscard]] ShardBundle AdjustShard(const OdometryOptions& options,
                                      const OdometryInput& input,
                                      std::vector<ChainedFrame>* frames);

}  // namespace nightmap
