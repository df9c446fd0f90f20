// SPDX-License-Identifier: Apache-2.0
// What the keyframes say of a voxel that some of them measured: depth maps held against each other,
// as in Merrell et al., Real-time visibility-based fusion of depth maps, 2007.
#pragma once

#include "stages/point_cloud/point_cloud.h"
#include "stages/point_cloud/voxel_filter.h"

namespace nightmap {

enum class Testimony { kNone, kConfirms, kSeesThrough };

// A keyframe's depth, in which points of the map are looked up.
class DepthView {
 public:
  DepthView(const RgbdCamera& camera, const Rigid3& map_from_camera, DepthImage depth);

  // Confirms: the pixel at the point's place has its depth within DepthTolerance_m, or one beside
  // it has and that one lies behind. Sees through: that pixel and all beside it lie behind the
  // point. Nothing of points deeper than max_depth_m, hidden, outside the picture, or where nothing
  // was measured.
  Testimony Of(const PointCloudOptions& options, const Eigen::Vector3d& point_in_map) const;
  // False only when nothing can be said of any point of the ball.
  bool Reaches(const Eigen::Vector3d& centre_in_map, double radius_m, double max_depth_m) const;

 private:
  // Where the pixel itself lies behind a point.
  Testimony BesidePixel(int at_x, int at_y, double depth_m, double tolerance_m) const;

  const RgbdCamera* camera_;
  Eigen::Matrix3d rotation_;  // camera_from_map
  Eigen::Vector3d translation_;
  DepthImage depth_;
  double max_tangent_ = 0;  // of the angle between the optical axis and a pixel's ray
};

// Drops voxels that fewer than min_consistent_frames keyframes confirm, or that more see through
// than confirm. A keyframe that measured the voxel confirms it as a rule. Reads the depth of each
// keyframe once more, four a thread at a time; one that is unreadable says nothing. What becomes of
// a voxel depends on its position and on the keyframes with it in view, so a cloud made in parts
// loses the same voxels. Same result at any number of threads.
SortedVoxels RemoveInconsistent(const PointCloudOptions& options,
                                const SortedVoxels& voxels,
                                const KeyframeSource& source,
                                Progress& progress,
                                int num_threads);

}  // namespace nightmap
