// SPDX-License-Identifier: Apache-2.0
// Surface patches sampled from depth images.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/dense/tiles_io.h"
#include "pipeline/geometry/rigid3.h"
#include "stages/dense/map_frame/map_frame.h"

namespace nightmap {

// A small patch of surface.
struct SurfacePatch {
  Eigen::Vector3d point;   // in the given frame
  Eigen::Vector3d normal;  // towards the camera
  double area_m2 = 0;      // surface area that this sample stands for
  int camera_idx = -1;     // index among the keyframes of the camera that saw it; -1: unknown
};

inline double Angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
}

// Patches of one depth image on a coarse pixel grid, where the surface is smooth. camera_idx stays
// unknown.
std::vector<SurfacePatch> SamplePatches(const DepthImage& depth,
                                        const RgbdCamera& camera,
                                        const Rigid3& given_from_camera,
                                        double max_depth_m);

// Patches of about options.floor_num_keyframes depth images at most, spread evenly over all of the
// input's keyframes and limited to `keyframes`. camera_idx is the index of the keyframe. Poses are
// given_from_camera. An unreadable depth image gives no patch. Deterministic.
std::vector<SurfacePatch> SampleKeyframes(const MapFrameOptions& options,
                                          const MapFrameInput& input,
                                          const std::vector<Keyframe>& keyframes,
                                          int num_threads);

}  // namespace nightmap
