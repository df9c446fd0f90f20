// SPDX-License-Identifier: Apache-2.0
// Turns a keyframe's depth pixels into the points whose rays count.
#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/dense/back_project.h"
#include "pipeline/dense/ply_io.h"
#include "pipeline/geometry/rigid3.h"
#include "stages/dense/octree/trace_rays.h"
#include "stages/dense/octree/voxel_block.h"

namespace nightmap {

// The voxels of a cloud and the 26 around each. Throws DataError when a point is beyond reach_m.
class CloudSupport {
 public:
  CloudSupport(const std::vector<CloudPoint>& cloud, double resolution_m, double reach_m);
  bool Holds(const Eigen::Vector3d& point_in_map) const;

 private:
  double resolution_m_;
  BlockMap<BlockBits> voxels_;
};

struct SupportedRays {
  KeyframeRays rays;
  std::size_t num_unsupported = 0;  // points in range that the cloud does not support
};

// Leaves out points within range that `support` does not hold (null: keeps all).
SupportedRays MakeKeyframeRays(const std::vector<DepthPoint>& points,
                               const Rigid3& map_from_camera,
                               double margin_sigmas,
                               double max_range_m,
                               const CloudSupport* support);

}  // namespace nightmap
