// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/geometry/fisheye.h"

namespace nightmap {
namespace {

constexpr int kMaxIterations = 30;
constexpr double kConverged = 1e-12;  // on the z = 1 plane, far below any pixel

// Radial part of the pinhole's model, and half its derivative by r: d/dr2.
struct Radial {
  double value;
  double slope;
};

double Numerator(const Camera& c, double r2) { return 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3)); }
double Denominator(const Camera& c, double r2) { return 1 + r2 * (c.k4 + r2 * (c.k5 + r2 * c.k6)); }
double DenominatorSlope(const Camera& c, double r2) {
  return c.k4 + r2 * (2 * c.k5 + 3 * r2 * c.k6);
}

Radial RadialAt(const Camera& c, double r2) {
  const double denominator = Denominator(c, r2);
  const double value = Numerator(c, r2) / denominator;
  const double slope = c.k1 + r2 * (2 * c.k2 + 3 * r2 * c.k3);
  return {value, (slope - value * DenominatorSlope(c, r2)) / denominator};
}

// Distorts a point of a pinhole; both points are on the plane z = 1.
Eigen::Vector2d Distort(const Camera& camera, const Eigen::Vector2d& point) {
  const double x = point.x(), y = point.y();
  const double r2 = x * x + y * y;
  const double radial = Numerator(camera, r2) / Denominator(camera, r2);
  return {x * radial + 2 * camera.p1 * x * y + camera.p2 * (r2 + 2 * x * x),
          y * radial + camera.p1 * (r2 + 2 * y * y) + 2 * camera.p2 * x * y};
}

// Derivative of Distort.
Eigen::Matrix2d DistortJacobian(const Camera& camera, const Eigen::Vector2d& point) {
  const double x = point.x(), y = point.y();
  const auto [radial, half_slope] = RadialAt(camera, x * x + y * y);
  const double slope = 2 * half_slope;
  Eigen::Matrix2d jacobian;
  const double cross = x * y * slope + 2 * (camera.p1 * x + camera.p2 * y);
  jacobian << radial + x * x * slope + 2 * camera.p1 * y + 6 * camera.p2 * x, cross, cross,
      radial + y * y * slope + 6 * camera.p1 * y + 2 * camera.p2 * x;
  return jacobian;
}

// Whether the distorted radius rises at a radius, without the tangential part.
bool RisesAt(const Camera& c, double r2) {
  const double denominator = Denominator(c, r2);
  const double rise = 1 + r2 * (3 * c.k1 + r2 * (5 * c.k2 + r2 * 7 * c.k3));
  return denominator > 0 &&
         rise * denominator - 2 * r2 * Numerator(c, r2) * DenominatorSlope(c, r2) > 0;
}

// Far from the axis the model can turn back and would fold points into the image. A quotient may
// turn twice on the way.
bool IsFolded(const Camera& camera, const Eigen::Vector2d& point) {
  constexpr int kSteps = 16;
  const double r2 = point.squaredNorm();
  if (!RisesAt(camera, r2)) return true;
  if (!camera.IsRational()) return false;
  for (int i = 1; i < kSteps; ++i) {
    if (!RisesAt(camera, r2 * i * i / (kSteps * kSteps))) return true;
  }
  return false;
}

}  // namespace

Camera Camera::WithFocalScale(double scale) const {
  Camera camera = lens == Lens::kFisheye ? RefitFisheye(*this, scale) : *this;
  camera.fx *= scale;
  camera.fy *= scale;
  if (lens == Lens::kFisheye) return camera;
  const double scale2 = scale * scale;
  camera.k1 *= scale2;
  camera.k2 *= scale2 * scale2;
  camera.k3 *= scale2 * scale2 * scale2;
  camera.k4 *= scale2;
  camera.k5 *= scale2 * scale2;
  camera.k6 *= scale2 * scale2 * scale2;
  camera.p1 *= scale;
  camera.p2 *= scale;
  return camera;
}

std::optional<Eigen::Vector2d> Camera::Project(const Eigen::Vector3d& point_in_camera) const {
  if (!(point_in_camera.z() > 0)) return std::nullopt;
  Eigen::Vector2d point = point_in_camera.head<2>() / point_in_camera.z();
  if (lens == Lens::kFisheye) {
    const auto distorted = DistortFisheye(*this, point);
    if (!distorted) return std::nullopt;
    point = *distorted;
  } else if (HasDistortion()) {
    if (IsFolded(*this, point)) return std::nullopt;
    point = Distort(*this, point);
  }
  return Eigen::Vector2d(fx * point.x() + cx, fy * point.y() + cy);
}

Eigen::Vector2d Camera::Normalize(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!HasDistortion()) return distorted;
  if (lens == Lens::kFisheye) return UndistortFisheye(*this, distorted);
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
  return point.allFinite() ? point : distorted;
}

Eigen::Vector2d Camera::Undistort(const Eigen::Vector2d& pixel) const {
  if (!HasDistortion()) return pixel;
  const Eigen::Vector2d point = Normalize(pixel);
  return {fx * point.x() + cx, fy * point.y() + cy};
}

bool Camera::Sees(const Eigen::Vector2d& pixel) const {
  constexpr double kSame_px = 0.01;
  const auto again = Project(BackProject(pixel, 1));
  return again && (*again - pixel).norm() < kSame_px;
}

namespace {

// The ray of a pixel if its lens were ideal, scaled to z = 1; nothing where a fisheye's circle may
// end.
std::optional<Eigen::Vector3d> IdealRay(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = camera.BackProjectUndistorted(pixel, 1);
  const double angle_rad = ray.head<2>().norm();
  if (camera.lens == Lens::kPinhole || angle_rad == 0) return ray;
  if (angle_rad > kMaxFisheyeAngle_rad) return std::nullopt;
  return Eigen::Vector3d(ray.x(), ray.y(), angle_rad / std::tan(angle_rad));
}

}  // namespace

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
      const auto ideal = IdealRay(camera, pixel);
      if (!ideal) continue;
      const auto moved = camera.Project(*ideal);
      if (!moved) return std::numeric_limits<double>::infinity();
      largest_px = std::max(largest_px, (*moved - pixel).norm());
    }
  }
  return largest_px / std::hypot(0.5 * camera.width, 0.5 * camera.height);
}

}  // namespace nightmap
