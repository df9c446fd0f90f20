// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace nightmap {
namespace {

constexpr int kMaxIterations = 30;
constexpr double kConverged = 1e-12;  // on the z = 1 plane, far below any pixel

// Distorts a point; both points are on the plane z = 1.
Eigen::Vector2d Distort(const Camera& camera, const Eigen::Vector2d& point) {
  const double x = point.x(), y = point.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (camera.k1 + r2 * (camera.k2 + r2 * camera.k3));
  return {x * radial + 2 * camera.p1 * x * y + camera.p2 * (r2 + 2 * x * x),
          y * radial + camera.p1 * (r2 + 2 * y * y) + 2 * camera.p2 * x * y};
}

// Derivative of Distort.
Eigen::Matrix2d DistortJacobian(const Camera& camera, const Eigen::Vector2d& point) {
  const double x = point.x(), y = point.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (camera.k1 + r2 * (camera.k2 + r2 * camera.k3));
  const double slope =
      2 * (camera.k1 + r2 * (2 * camera.k2 + 3 * r2 * camera.k3));  // d radial/dr2 * 2
  Eigen::Matrix2d jacobian;
  const double cross = x * y * slope + 2 * (camera.p1 * x + camera.p2 * y);
  jacobian << radial + x * x * slope + 2 * camera.p1 * y + 6 * camera.p2 * x, cross, cross,
      radial + y * y * slope + 6 * camera.p1 * y + 2 * camera.p2 * x;
  return jacobian;
}

// Far from the axis the polynomial can turn back and would fold points into the image.
bool IsFolded(const Camera& camera, const Eigen::Vector2d& point) {
  const double r2 = point.squaredNorm();
  return 1 + r2 * (3 * camera.k1 + r2 * (5 * camera.k2 + r2 * 7 * camera.k3)) <= 0;
}

}  // namespace

Camera Camera::WithFocalScale(double scale) const {
  Camera camera = *this;
  const double scale2 = scale * scale;
  camera.fx *= scale;
  camera.fy *= scale;
  camera.k1 *= scale2;
  camera.k2 *= scale2 * scale2;
  camera.k3 *= scale2 * scale2 * scale2;
  camera.p1 *= scale;
  camera.p2 *= scale;
  return camera;
}

std::optional<Eigen::Vector2d> Camera::Project(const Eigen::Vector3d& point_in_camera) const {
  if (!(point_in_camera.z() > 0)) return std::nullopt;
  Eigen::Vector2d point = point_in_camera.head<2>() / point_in_camera.z();
  if (HasDistortion()) {
    if (IsFolded(*this, point)) return std::nullopt;
    point = Distort(*this, point);
  }
  return Eigen::Vector2d(fx * point.x() + cx, fy * point.y() + cy);
}

Eigen::Vector2d Camera::Normalize(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!HasDistortion()) return distorted;
  Eigen::Vector2d point = distorted;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector2d residual = Distort(*this, point) - distorted;
    const Eigen::Matrix2d jacobian = DistortJacobian(*this, point);
    // Where the model folds, Newton's step would leap away, but the fixed-point step stays near.
    const bool regular = jacobian.determinant() > 0.05;
    const Eigen::Vector2d step =
        regular ? Eigen::Vector2d(jacobian.inverse() * residual) : residual;
    point -= step;
    if (step.squaredNorm() < kConverged * kConverged) break;
  }
  return point;
}

Eigen::Vector2d Camera::Undistort(const Eigen::Vector2d& pixel) const {
  if (!HasDistortion()) return pixel;
  const Eigen::Vector2d point = Normalize(pixel);
  return {fx * point.x() + cx, fy * point.y() + cy};
}

double LargestDistortion(const Camera& camera) {
  constexpr int kSteps = 16;
  constexpr double kInner = 0.9;  // calibrations often miss the corners
  double largest_px = 0;
  for (int row = 0; row <= kSteps; ++row) {
    for (int column = 0; column <= kSteps; ++column) {
      const Eigen::Vector2d middle(0.5 * camera.width, 0.5 * camera.height);
      const Eigen::Vector2d off((2.0 * column / kSteps - 1) * middle.x(),
                                (2.0 * row / kSteps - 1) * middle.y());
      const Eigen::Vector2d pixel = middle + kInner * off;
      const auto moved = camera.Project(camera.BackProjectUndistorted(pixel, 1));
      if (!moved) return std::numeric_limits<double>::infinity();
      largest_px = std::max(largest_px, (*moved - pixel).norm());
    }
  }
  return largest_px / std::hypot(0.5 * camera.width, 0.5 * camera.height);
}

}  // namespace nightmap
