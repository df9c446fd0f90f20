// SPDX-License-Identifier: Apache-2.0
// Checks a measured voxel against the depth of other keyframes, as in Merrell et al., Real-time
// visibility-based fusion of depth maps, 2007.
#pragma once

#include "stages/dense/point_cloud/point_cloud.h"
#include "stages/dense/point_cloud/voxel_filter.h"

namespace nightmap {

enum class Testimony { kNone, kConfirms, kSeesThrough };

// A keyframe's depth, for looking up points of the map.
class DepthView {
 public:
  DepthView(const RgbdCamera& camera, const Rigid3& map_from_camera, DepthImage depth);

  // Confirms: the pixel at the point's projection has its depth within DepthTolerance_m, or a
  // neighbouring pixel does and the pixel itself lies behind. Sees through: the pixel and all its
  // neighbours lie behind the point. Nothing: points deeper than max_depth_m, hidden, outside the
  // picture, or where nothing was measured.
  Testimony Of(const PointCloudOptions& options, const Eigen::Vector3d& point_in_map) const;
  // False only when nothing can be said about any point of the ball.
  bool Reaches(const Eigen::Vector3d& centre_in_map, double radius_m, double max_depth_m) const;

 private:
  // Testimony when the pixel itself lies behind a point.
  Testimony BesidePixel(int at_x, int at_y, double depth_m, double tolerance_m) const;

  const RgbdCamera* camera_;
  Eigen::Matrix3d rotation_;  // camera_from_map
  Eigen::Vector3d translation_;
  DepthImage depth_;
  // Tangent of the largest angle between the optical axis and a pixel's ray.
  double max_tangent_ = 0;
};

// Drops voxels that fewer than min_consistent_frames keyframes confirm, or that more keyframes see
// through than confirm. A keyframe that measured the voxel usually confirms it. Reads the depth of
// each keyframe once more, four per thread at a time; an unreadable one counts neither way. The
// decision on a voxel depends on its position and on the keyframes that see it, so a cloud made in
// parts loses the same voxels. Same result at any number of threads.
SortedVoxels RemoveInconsistent(const PointCloudOptions& options,
                                const SortedVoxels& voxels,
                                const KeyframeSource& source,
                                Progress& progress,
                                int num_threads);

}  // namespace nightmap
