// SPDX-License-Identifier: Apache-2.0
// Patches of the surfaces that depth images see.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/tiles_io.h"
#include "stages/map_frame/map_frame.h"

namespace nightmap {

// A small patch of surface.
struct SurfacePatch {
  Eigen::Vector3d point;   // in the given frame
  Eigen::Vector3d normal;  // towards the camera
  double area_m2 = 0;      // share of the surface this sample stands for
  int camera_idx = -1;     // of the camera that saw it, among the keyframes; -1: unknown
};

inline double Angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
}

// Patches of one depth image on a coarse pixel grid, where the surface is smooth. Their camera_idx
// is unknown.
std::vector<SurfacePatch> SamplePatches(const DepthImage& depth,
                                        const RgbdCamera& camera,
                                        const Rigid3& given_from_camera,
                                        double max_depth_m);

// Those of the depth images of at most about options.floor_num_keyframes of `keyframes` that lie
// evenly among all of the input's, with the keyframe_idx as camera_idx. Their poses are
// given_from_camera. A depth image that cannot be read has none. Deterministic.
std::vector<SurfacePatch> SampleKeyframes(const MapFrameOptions& options,
                                          const MapFrameInput& input,
                                          const std::vector<Keyframe>& keyframes,
                                          int num_threads);

}  // namespace nightmap
