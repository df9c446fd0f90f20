// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/light_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr double kLampReach_m = 6;
constexpr double kAmbientReach_m = 1.2;
constexpr float kAmbient = 0.42F;
constexpr double kLift_m = 2e-3;  // start of rays above the surface

// A right-handed frame whose third axis is the normal.
Eigen::Matrix3d FrameOf(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d helper =
      std::abs(normal.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  Eigen::Matrix3d frame;
  frame.col(0) = helper.cross(normal).normalized();
  frame.col(1) = normal.cross(frame.col(0));
  frame.col(2) = normal;
  return frame;
}

// Share of the hemisphere without nearby surfaces.
float AmbientShare(const Eigen::Vector3d& point,
                   const Eigen::Vector3d& normal,
                   const RayScene& rays,
                   int num_samples,
                   Random& random) {
  const Eigen::Matrix3d frame = FrameOf(normal);
  int num_open = 0;
  for (int i = 0; i < num_samples; ++i) {
    const double radius = std::sqrt((i + random.Uniform()) / num_samples);  // cosine weighted
    const double angle_rad = 2 * std::numbers::pi * random.Uniform();
    const Eigen::Vector3d local(radius * std::cos(angle_rad),
                                radius * std::sin(angle_rad),
                                std::sqrt(std::max(0.0, 1 - radius * radius)));
    if (!rays.IsBlocked(point, frame * local, kAmbientReach_m)) ++num_open;
  }
  return static_cast<float>(num_open) / static_cast<float>(num_samples);
}

// Irradiance from one lamp, averaged over points on it.
float LampLight(const Lamp& lamp,
                const Eigen::Vector3d& point,
                const Eigen::Vector3d& normal,
                const RayScene& rays,
                int num_samples,
                Random& random) {
  double sum = 0;
  for (int i = 0; i < num_samples; ++i) {
    const Eigen::Vector3d on_lamp =
        lamp.center + Eigen::Vector3d(lamp.half_size.x() * random.Uniform(-1, 1),
                                      lamp.half_size.y() * random.Uniform(-1, 1),
                                      -0.02);
    const Eigen::Vector3d to_lamp = on_lamp - point;
    const double squared = to_lamp.squaredNorm();
    const double facing = normal.dot(to_lamp);
    if (facing <= 0 || to_lamp.z() <= 0 || rays.IsBlocked(point, to_lamp, 1.0)) continue;
    // Both cosines; one of them is softened so that walls near the lamp are not overexposed.
    sum += facing * std::sqrt(to_lamp.z()) / (squared * std::sqrt(std::sqrt(squared)) + 0.7);
  }
  return lamp.intensity * static_cast<float>(sum / num_samples);
}

float Brightness(const Scene& scene,
                 const RayScene& rays,
                 const Eigen::Vector3d& point,
                 const Eigen::Vector3d& normal,
                 int num_samples,
                 Random& random) {
  float sum = kAmbient * AmbientShare(point, normal, rays, num_samples, random);
  for (const Lamp& lamp : scene.lamps) {
    if ((lamp.center - point).squaredNorm() > kLampReach_m * kLampReach_m) continue;
    const int num_lamp_samples = std::max(1, num_samples / 4);
    sum += 0.62F * LampLight(lamp, point, normal, rays, num_lamp_samples, random);
  }
  return sum;
}

}  // namespace

LightMap::LightMap(const Scene& scene,
                   const RayScene& rays,
                   double cell_m,
                   int num_samples,
                   std::uint64_t seed,
                   int num_threads) {
  std::size_t total = 0;
  for (const Surface& surface : scene.surfaces) {
    Grid grid;
    grid.num_u = 1 + std::max(1, static_cast<int>(std::ceil(surface.edge_u.norm() / cell_m)));
    grid.num_v = 1 + std::max(1, static_cast<int>(std::ceil(surface.edge_v.norm() / cell_m)));
    grid.first = total;
    total += static_cast<std::size_t>(grid.num_u * grid.num_v);
    grids_.push_back(grid);
  }
  samples_.resize(total);
  ParallelFor(grids_.size(), num_threads, [&](std::size_t surface_idx) {
    const Surface& surface = scene.surfaces[surface_idx];
    const Grid& grid = grids_[surface_idx];
    const Eigen::Vector3d normal = surface.Normal();
    Random random(seed, 301, surface_idx);
    for (int i = 0; i < grid.num_u * grid.num_v; ++i) {
      // Slightly inside the border, because the next surface begins there.
      const int row = i / grid.num_u;
      const double a =
          std::clamp(static_cast<double>(i % grid.num_u) / (grid.num_u - 1), 0.01, 0.99);
      const double b = std::clamp(static_cast<double>(row) / (grid.num_v - 1), 0.01, 0.99);
      const Eigen::Vector3d point =
          surface.origin + a * surface.edge_u + b * surface.edge_v + kLift_m * normal;
      samples_[grid.first + static_cast<std::size_t>(i)] =
          Brightness(scene, rays, point, normal, num_samples, random);
    }
  });
}

float LightMap::At(int surface_idx, double a, double b) const {
  const Grid& grid = grids_[static_cast<std::size_t>(surface_idx)];
  const float x = static_cast<float>(a) * static_cast<float>(grid.num_u - 1);
  const float y = static_cast<float>(b) * static_cast<float>(grid.num_v - 1);
  const int x0 = std::clamp(static_cast<int>(x), 0, grid.num_u - 2);
  const int y0 = std::clamp(static_cast<int>(y), 0, grid.num_v - 2);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const float* top = &samples_[grid.first + static_cast<std::size_t>(y0 * grid.num_u + x0)];
  const float* bottom = top + grid.num_u;
  return (1 - fy) * ((1 - fx) * top[0] + fx * top[1]) +
         fy * ((1 - fx) * bottom[0] + fx * bottom[1]);
}

}  // namespace nightmap
