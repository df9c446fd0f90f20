// SPDX-License-Identifier: Apache-2.0
// Patches of the surfaces that depth images see.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

struct PoseGraphInput;

// A small patch of surface.
struct SurfacePatch {
  Eigen::Vector3d point;   // in the graph frame
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
                                        const Rigid3& graph_from_camera,
                                        double max_depth_m);

// Those of the keyframes' depth images, of at most about `max_num_keyframes` that lie evenly among
// them, with the place of the keyframe in the map as camera_idx. A depth image that cannot be read
// has none. Deterministic.
std::vector<SurfacePatch> SampleKeyframes(const PoseGraphInput& input,
                                          const std::map<int, Rigid3>& graph_from_keyframe,
                                          int max_num_keyframes,
                                          double max_depth_m,
                                          int num_threads);

}  // namespace nightmap
