// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/fisheye.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

constexpr double kStep_rad = 0.025;  // in which no lens turns back and forth again

double RadiusAt(const Camera& c, double angle_rad) {
  const double t = angle_rad * angle_rad;
  return angle_rad * (1 + t * (c.k1 + t * (c.k2 + t * (c.k3 + t * c.k4))));
}

double SlopeAt(const Camera& c, double angle_rad) {
  const double t = angle_rad * angle_rad;
  return 1 + t * (3 * c.k1 + t * (5 * c.k2 + t * (7 * c.k3 + t * 9 * c.k4)));
}

bool RisesTo(const Camera& camera, double angle_rad) {
  for (double at_rad = kStep_rad; at_rad < angle_rad; at_rad += kStep_rad) {
    if (SlopeAt(camera, at_rad) <= 0) return false;
  }
  return SlopeAt(camera, angle_rad) > 0;
}

// The angle of a radius; that of the largest radius which has one for larger ones.
double AngleOf(const Camera& camera, double radius) {
  double below_rad = 0, above_rad = 0;
  while (RadiusAt(camera, above_rad) < radius) {
    if (above_rad == kMaxFisheyeAngle_rad) return above_rad;
    below_rad = above_rad;
    above_rad = std::min(above_rad + kStep_rad, kMaxFisheyeAngle_rad);
    if (SlopeAt(camera, above_rad) <= 0) return below_rad;
  }
  double angle_rad = below_rad;
  for (int i = 0; i < 30; ++i) {
    const double step_rad = (RadiusAt(camera, angle_rad) - radius) / SlopeAt(camera, angle_rad);
    angle_rad = std::clamp(angle_rad - step_rad, below_rad, above_rad);
    if (std::abs(step_rad) < 1e-14) break;
  }
  return angle_rad;
}

double LargestAngleInPicture(const Camera& camera) {
  double radius = 0;
  for (const double x : {0, camera.width - 1}) {
    for (const double y : {0, camera.height - 1}) {
      radius =
          std::max(radius, std::hypot((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy));
    }
  }
  return AngleOf(camera, radius);
}

}  // namespace

std::optional<Eigen::Vector2d> DistortFisheye(const Camera& camera, const Eigen::Vector2d& point) {
  const double tangent = point.norm();
  if (tangent == 0) return point;
  const double angle_rad = std::atan(tangent);
  if (!(angle_rad <= kMaxFisheyeAngle_rad) || !RisesTo(camera, angle_rad)) return std::nullopt;
  return point * (RadiusAt(camera, angle_rad) / tangent);
}

Eigen::Vector2d UndistortFisheye(const Camera& camera, const Eigen::Vector2d& distorted) {
  const double radius = distorted.norm();
  return radius == 0 ? distorted : distorted * (std::tan(AngleOf(camera, radius)) / radius);
}

Camera RefitFisheye(const Camera& camera, double scale) {
  constexpr int kSamples = 64;
  const double end_rad = LargestAngleInPicture(camera);
  Eigen::Matrix<double, kSamples, 4> powers;
  Eigen::Matrix<double, kSamples, 1> radii;
  for (int i = 0; i < kSamples; ++i) {
    const double angle_rad = end_rad * (i + 1) / kSamples;
    const double scaled_rad = std::atan(std::tan(angle_rad) / scale);
    const double t = scaled_rad * scaled_rad;
    powers.row(i) = scaled_rad * Eigen::RowVector4d(t, t * t, t * t * t, t * t * t * t);
    radii(i) = RadiusAt(camera, angle_rad) / scale - scaled_rad;
  }
  const Eigen::Vector4d k = powers.colPivHouseholderQr().solve(radii);
  Camera refitted = camera;
  refitted.k1 = k(0);
  refitted.k2 = k(1);
  refitted.k3 = k(2);
  refitted.k4 = k(3);
  return refitted;
}

}  // namespace nightmap
