// SPDX-License-Identifier: Apache-2.0
// The map's landmarks in its keyframes as a least squares problem, for our solvers and for Ceres.
#pragma once

#include <ceres/ceres.h>

#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"
#include "tests/bench/libraries/mapped_site.h"

namespace nightmap {

// As in a program that has Ceres derive: rotation as quaternion (x y z w), then translation.
struct CeresResidual {
  const BundleObservation& seen;
  const Camera& camera;

  template <typename T>
  bool operator()(const T* rotation, const T* translation, const T* point, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> turn(rotation);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> shift(translation);
    const Eigen::Matrix<T, 3, 1> p = turn * Eigen::Map<const Eigen::Matrix<T, 3, 1>>(point) + shift;
    if (p.z() < T(Reprojection::kMinDepth_m)) return false;
    residual[0] = (camera.fx * p.x() / p.z() + camera.cx - seen.pixel.x()) / seen.pixel_sigma_px;
    residual[1] = (camera.fy * p.y() / p.z() + camera.cy - seen.pixel.y()) / seen.pixel_sigma_px;
    residual[2] =
        seen.depth_m > 0 ? (p.z() - seen.depth_m) / seen.noise.Sigma_m(seen.depth_m) : T(0);
    return true;
  }
};

inline void AddResidual(const BundleObservation& seen,
                        const Camera& camera,
                        ceres::LossFunction* loss,
                        Rigid3& pose,
                        Eigen::Vector3d& point,
                        ceres::Problem& problem) {
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<CeresResidual, 3, 4, 3, 3>(new CeresResidual{seen, camera}),
      loss,
      pose.rotation.coeffs().data(),
      pose.translation.data(),
      point.data());
}

// Every sighting of a landmark, at the poses and points of the map. The first pose is fixed.
BundleProblem MakeLandmarkProblem(const MappedSite& site);

// Moves the poses by 1 cm and 0.3 degrees (standard deviation per axis), the points by 2 cm.
void Disturb(BundleProblem* problem);

// The largest distance between the camera centres of two lists of camera_from_world.
double LargestShift_mm(const std::vector<Rigid3>& a, const std::vector<Rigid3>& b);

}  // namespace nightmap
