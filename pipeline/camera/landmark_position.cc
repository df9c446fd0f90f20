// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <cmath>

#include "pipeline/camera/landmark_tracker.h"

namespace nightmap {

void PointEstimate::Add(const Observer& observer, int feature, double z_m, double pixel_sigma_px) {
  const FeatureView seen = observer.features->Feature(feature);
  const Camera& camera = observer.camera->color;
  const double depth_m = seen.Depth_m();
  if (depth_m > 0) z_m = depth_m;
  // The keypoint is undistorted already.
  const Eigen::Vector3d ray_in_camera = camera.BackProjectUndistorted(seen.Pixel(), 1.0);
  const Eigen::Vector3d direction = observer.map_from_camera.rotation * ray_in_camera.normalized();
  const double across_sigma_m = pixel_sigma_px * z_m / camera.fx;
  const double along_sigma_m = observer.camera->noise.Sigma_m(z_m) * ray_in_camera.norm();
  const double across_weight = 1.0 / (across_sigma_m * across_sigma_m);
  const double along_weight = depth_m > 0 ? 1.0 / (along_sigma_m * along_sigma_m) : 0.0;
  const Eigen::Matrix3d along = direction * direction.transpose();
  const Eigen::Matrix3d weight =
      along_weight * along + across_weight * (Eigen::Matrix3d::Identity() - along);
  information_ += weight;
  weighted_sum_ += weight * (observer.map_from_camera * (z_m * ray_in_camera));
}

Eigen::Vector3d PointEstimate::Position() const { return information_.inverse() * weighted_sum_; }

double PointEstimate::Sigma_m() const {
  const double trace = information_.inverse().trace();
  return trace > 0 ? std::sqrt(trace / 3.0) : std::numeric_limits<double>::infinity();
}

}  // namespace nightmap
