// SPDX-License-Identifier: Apache-2.0
// Cameras with OpenCV's lens models. Downstream of Undistort all is a pinhole camera.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace nightmap {

enum class Lens { kPinhole, kFisheye };

// Camera frame: x right, y down, z forward. Pixel (0, 0) is the centre of the top left pixel.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  // Distortion, dimensionless. A pinhole has the rational model (k1 k2 p1 p2 k3 k4 k5 k6 of
  // cv::projectPoints), a fisheye the polynomial in the angle to the axis (k1 k2 k3 k4 of
  // cv::fisheye; Kannala and Brandt, PAMI 2006); what its model has not is 0.
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  double k4 = 0, k5 = 0, k6 = 0;
  Lens lens = Lens::kPinhole;

  bool operator==(const Camera&) const = default;
  bool IsRational() const { return k4 != 0 || k5 != 0 || k6 != 0; }
  bool HasDistortion() const {
    return lens == Lens::kFisheye || k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0 ||
           IsRational();
  }
  bool Contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= width - 1 && pixel.y() <= height - 1;
  }

  // The camera that has this one's undistorted image with focal lengths `scale` times as long: each
  // undistorted pixel stays, and its ray gets steeper by 1 / scale. The fisheye's model holds this
  // only nearly: its polynomial is fitted to the field of the picture.
  Camera WithFocalScale(double scale) const;

  // Pixel of a point in the camera frame, possibly outside the image. Nothing for z <= 0, where the
  // distortion has turned back, and beyond 80 deg from a fisheye's axis.
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
  // Ray through a pixel, scaled to z = 1, distortion removed (Newton iteration). Finite, and of no
  // meaning where the camera does not see the pixel.
  Eigen::Vector2d Normalize(const Eigen::Vector2d& pixel) const;
  // Whether Project takes the pixel's ray back to it: no beyond the circle of a fisheye, and where
  // the model has no inverse. `frames` and `queries` mask such pixels (camera_masks.h).
  bool Sees(const Eigen::Vector2d& pixel) const;
  // Point at a depth (z, metres) behind a pixel.
  Eigen::Vector3d BackProject(const Eigen::Vector2d& pixel, double depth_m) const {
    const Eigen::Vector2d ray = Normalize(pixel);
    return {ray.x() * depth_m, ray.y() * depth_m, depth_m};
  }
  // The pixel of the same ray in this camera without distortion. Features are stored undistorted.
  Eigen::Vector2d Undistort(const Eigen::Vector2d& pixel) const;
};

// How far distortion moves a pixel of the inner nine tenths of the picture at most, as a share of
// half its diagonal; infinite where the model turns back, as no lens does. A fisheye's is measured
// from the lens whose radius is the angle.
double LargestDistortion(const Camera& camera);

}  // namespace nightmap
