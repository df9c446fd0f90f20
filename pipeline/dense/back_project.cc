// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/back_project.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

// A pixel is on an edge when a neighbour's depth differs by more than this share.
constexpr double kMaxDepthJump = 0.04;

class FrameBackProjector {
 public:
  FrameBackProjector(const DepthImage& depth,
                     const RayTable& rays,
                     const RgbdCamera& camera,
                     const DepthFilterOptions& options)
      : depth_(depth),
        rays_(rays),
        noise_(camera.noise),
        focal_px_(camera.color.fx),
        options_(options),
        min_cos_incidence_(std::cos(options.max_incidence_rad)) {}

  double Sigma_m(float depth_m) const { return noise_.Sigma_m(depth_m); }

  Eigen::Vector3f Point(int x, int y) const {
    const float z = depth_.At(x, y);
    const Eigen::Vector2f& ray =
        rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(depth_.width) +
              static_cast<std::size_t>(x)];
    return {ray.x() * z, ray.y() * z, z};
  }

  bool OnEdge(int x, int y) const {
    const float z = depth_.At(x, y);
    const float max_jump_m = MaxJump_m(z);
    for (int radius = 1; radius <= options_.edge_radius_px; ++radius) {
      for (const auto& [dx, dy] : {std::pair{-radius, 0}, {radius, 0}, {0, -radius}, {0, radius}}) {
        const float other = DepthOrZero(x + dx, y + dy);
        if (other > 0 && std::abs(other - z) > max_jump_m) return true;
      }
    }
    return false;
  }

  // A pixel without the neighbours that a normal needs is kept.
  bool Grazing(int x, int y) const {
    if (min_cos_incidence_ < 1e-6) return false;
    const int radius = SlopeRadius_px(depth_.At(x, y));
    const auto along_x = Tangent(x, y, radius, 0);
    const auto along_y = Tangent(x, y, 0, radius);
    if (along_x.isZero() || along_y.isZero()) return false;
    const Eigen::Vector3f normal = along_x.cross(along_y).normalized();
    return std::abs(normal.dot(Point(x, y).normalized())) < min_cos_incidence_;
  }

 private:
  float MaxJump_m(float z) const {
    return static_cast<float>(std::max(kMaxDepthJump * z, 3 * std::sqrt(2.0) * Sigma_m(z)));
  }

  float DepthOrZero(int x, int y) const {
    const bool inside = x >= 0 && y >= 0 && x < depth_.width && y < depth_.height;
    return inside ? depth_.At(x, y) : 0.0F;
  }

  // Wide enough for the slope across it to exceed the noise of its ends.
  int SlopeRadius_px(float z) const {
    return std::clamp(static_cast<int>(std::ceil(3 * Sigma_m(z) * focal_px_ / z)), 3, 24);
  }

  // Difference of the points on both sides; zero when one was not measured.
  Eigen::Vector3f Tangent(int x, int y, int dx, int dy) const {
    if (DepthOrZero(x - dx, y - dy) <= 0 || DepthOrZero(x + dx, y + dy) <= 0) {
      return Eigen::Vector3f::Zero();
    }
    return Point(x + dx, y + dy) - Point(x - dx, y - dy);
  }

  const DepthImage& depth_;
  const RayTable& rays_;
  DepthNoise noise_;
  double focal_px_;
  const DepthFilterOptions& options_;
  double min_cos_incidence_;
};

void CheckSizes(const DepthImage& depth, const ColorImage& color, const RayTable& rays) {
  const bool agree = depth.width == color.width && depth.height == color.height &&
                     rays.size() == depth.pixels.size() && color.num_channels == 3;
  if (!agree) {
    throw DataError("depth is {} x {}, color {} x {}: both must have the camera's size",
                    depth.width,
                    depth.height,
                    color.width,
                    color.height);
  }
}

}  // namespace

RayTable MakeRayTable(const Camera& camera, int num_threads) {
  const auto width = static_cast<std::size_t>(camera.width);
  RayTable rays(width * static_cast<std::size_t>(camera.height));
  ParallelFor(static_cast<std::size_t>(camera.height), num_threads, [&](std::size_t y) {
    for (std::size_t x = 0; x < width; ++x) {
      const Eigen::Vector2d pixel(static_cast<double>(x), static_cast<double>(y));
      rays[y * width + x] = camera.Normalize(pixel).cast<float>();
    }
  });
  return rays;
}

std::vector<RayTable> MakeRayTables(const std::vector<RgbdCamera>& cameras, int num_threads) {
  std::vector<RayTable> tables;
  for (const RgbdCamera& camera : cameras)
    tables.push_back(MakeRayTable(camera.color, num_threads));
  return tables;
}

std::vector<DepthPoint> BackProjectDepth(const DepthImage& depth,
                                         const ColorImage& color,
                                         const RayTable& rays,
                                         const RgbdCamera& camera,
                                         double max_depth_m,
                                         const DepthFilterOptions& options) {
  CheckSizes(depth, color, rays);
  const FrameBackProjector projector(depth, rays, camera, options);
  std::vector<DepthPoint> points;
  for (int y = 0; y < depth.height; y += options.pixel_stride) {
    for (int x = 0; x < depth.width; x += options.pixel_stride) {
      const float z = depth.At(x, y);
      const bool measured = std::isfinite(z) && z > 0 && z <= max_depth_m;
      if (!measured || projector.OnEdge(x, y) || projector.Grazing(x, y)) continue;
      points.push_back({projector.Point(x, y),
                        static_cast<float>(projector.Sigma_m(z)),
                        {color.At(x, y, 0), color.At(x, y, 1), color.At(x, y, 2)}});
    }
  }
  return points;
}

}  // namespace nightmap
