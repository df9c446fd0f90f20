// SPDX-License-Identifier: Apache-2.0
// Clouds of known surfaces, and their meshes.
#pragma once

#include <cmath>
#include <numbers>

#include "pipeline/base/random.h"
#include "stages/dense/mesh/mesh.h"

namespace nightmap {

constexpr double kVoxel_m = 0.02;
constexpr double kNoise_m = 0.003;

inline CloudPoint PointAt(const Eigen::Vector3d& position,
                          const Eigen::Vector3d& normal,
                          Random& random) {
  CloudPoint point;
  point.position_in_map = (position + kNoise_m * random.Gaussian() * normal).cast<float>();
  point.normal_in_map = normal.cast<float>();
  point.rgb = {200, 100, 50};
  return point;
}

// A sphere around (0.3, -0.2, 1), seen from outside; a point per voxel or so (Fibonacci lattice).
struct Ball {
  Eigen::Vector3d centre{0.3, -0.2, 1};
  double radius_m = 0.7;

  MeshCloud Cloud() const {
    MeshCloud cloud{{}, kVoxel_m};
    Random random(1);
    const int num_points = static_cast<int>(16 * radius_m * radius_m / (kVoxel_m * kVoxel_m));
    for (int i = 0; i < num_points; ++i) {
      const double z = 1 - (2 * i + 1.0) / num_points;
      const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
      const double r = std::sqrt(1 - z * z);
      const Eigen::Vector3d normal(r * std::cos(angle), r * std::sin(angle), z);
      cloud.points.push_back(PointAt(centre + radius_m * normal, normal, random));
    }
    return cloud;
  }
};

// The plane z = 0.5 of edge 2 m, seen from above, without the points in a disc around the middle.
inline MeshCloud Table(double hole_radius_m) {
  MeshCloud cloud{{}, kVoxel_m};
  Random random(2);
  for (double x = -1; x < 1; x += kVoxel_m) {
    for (double y = -1; y < 1; y += kVoxel_m) {
      if (std::hypot(x, y) < hole_radius_m) continue;
      cloud.points.push_back(PointAt({x, y, 0.5}, Eigen::Vector3d::UnitZ(), random));
    }
  }
  return cloud;
}

inline TileMesh MeshOf(const MeshCloud& cloud, const Rectangle& tile = {}, int num_threads = 2) {
  return RunMesh(MeshOptions{}, cloud, tile, num_threads);
}

}  // namespace nightmap
