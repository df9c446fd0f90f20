// SPDX-License-Identifier: Apache-2.0
// Pinhole camera with OpenCV's radial-tangential distortion (k1 k2 p1 p2 k3).
#pragma once

#include <Eigen/Core>
#include <optional>

namespace nightmap {

// Camera frame: x right, y down, z forward. Pixel (0, 0) is the centre of the top left pixel.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;          // px
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;  // dimensionless

  bool operator==(const Camera&) const = default;
  bool HasDistortion() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0; }
  bool Contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= width - 1 && pixel.y() <= height - 1;
  }

  // The camera that has this one's undistorted image with focal lengths `scale` times as long: each
  // undistorted pixel stays, and its ray gets steeper by 1 / scale.
  Camera WithFocalScale(double scale) const;

  // Pixel of a point in the camera frame, possibly outside the image. Nothing for z <= 0 and where
  // the distortion polynomial has turned back.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_in_camera) const;
  // Likewise without distortion: pixels of undistorted keypoints.
  std::optional<Eigen::Vector2d> ProjectUndistorted(const Eigen::Vector3d& point_in_camera) const {
    if (point_in_camera.z() <= 0) return std::nullopt;
    return Eigen::Vector2d(fx * point_in_camera.x() / point_in_camera.z() + cx,
                           fy * point_in_camera.y() / point_in_camera.z() + cy);
  }
  // Point at a depth (z, metres) behind an undistorted pixel.
  Eigen::Vector3d BackProjectUndistorted(const Eigen::Vector2d& pixel, double depth_m) const {
    return {(pixel.x() - cx) / fx * depth_m, (pixel.y() - cy) / fy * depth_m, depth_m};
  }
  // Ray through a pixel, scaled to z = 1, distortion removed (Newton iteration).
  Eigen::Vector2d Normalize(const Eigen::Vector2d& pixel) const;
  // Point at a depth (z, metres) behind a pixel.
  Eigen::Vector3d BackProject(const Eigen::Vector2d& pixel, double depth_m) const {
    const Eigen::Vector2d ray = Normalize(pixel);
    return {ray.x() * depth_m, ray.y() * depth_m, depth_m};
  }
  // The pixel of the same ray in this camera without distortion. Features are stored undistorted.
  Eigen::Vector2d Undistort(const Eigen::Vector2d& pixel) const;
};

// How far distortion moves a pixel of the inner nine tenths of the picture at most, as a share of
// half its diagonal; infinite where the polynomial turns back, as no lens does.
double LargestDistortion(const Camera& camera);

}  // namespace nightmap
