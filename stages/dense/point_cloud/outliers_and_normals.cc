// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/outliers_and_normals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "stages/dense/point_cloud/radius_neighbors.h"

namespace nightmap {
namespace {

// A plane's neighbourhood spreads in two directions. Above this share of variance along the normal
// it is an edge or a corner, which projection would round off.
constexpr double kMaxFlatVariation = 0.1;
constexpr std::size_t kMinNeighbors = 5;

struct Plane {
  Eigen::Vector3d centre;
  Eigen::Vector3d normal;
  double variance_m2 = 0;
  double variation = 1;  // smallest eigenvalue over their sum: 0 flat, 1/3 shapeless

  bool IsFlat() const { return variation < kMaxFlatVariation; }
};

Plane FitPlane(const std::vector<VoxelSum>& sums,
               const std::vector<Eigen::Vector3d>& positions,
               std::size_t at,
               const std::vector<Neighbor>& neighbors,
               double radius_m) {
  const Eigen::Vector3d& origin = positions[at];
  double total = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const auto& [index, squared_distance_m2] : neighbors) {
    const double closeness = 1 - squared_distance_m2 / (radius_m * radius_m);
    const double weight = sums[index].weight * closeness;
    const Eigen::Vector3d offset = positions[index] - origin;
    total += weight;
    first += weight * offset;
    second += weight * offset * offset.transpose();
  }
  const Eigen::Vector3d mean = first / total;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(second / total - mean * mean.transpose());
  const double trace = solver.eigenvalues().sum();
  return {origin + mean,
          solver.eigenvectors().col(0),
          std::max(0.0, solver.eigenvalues()[0]),
          trace > 0 ? solver.eigenvalues()[0] / trace : 1.0};
}

VoxelSum OntoPlane(VoxelSum point, const Plane& plane, bool project) {
  const float side = plane.normal.dot(point.direction.cast<double>()) < 0 ? -1.0F : 1.0F;
  point.direction = side * plane.normal.cast<float>();
  if (project && plane.IsFlat()) {
    const Eigen::Vector3d position = point.Position();
    const double distance_m = plane.normal.dot(plane.centre - position);
    point.weighted_position = point.weight * (position + distance_m * plane.normal);
  }
  return point;
}

}  // namespace

SortedVoxels RemoveOutliers(const SortedVoxels& voxels,
                            double voxel_size_m,
                            double radius_m,
                            int min_neighbors,
                            int num_threads) {
  std::vector<char> keep(voxels.keys.size());
  ForEachNeighborhood(voxels.keys,
                      Positions(voxels.sums),
                      voxel_size_m,
                      radius_m,
                      num_threads,
                      [&](std::size_t i, const std::vector<Neighbor>& neighbors) {
                        keep[i] = neighbors.size() > static_cast<std::size_t>(min_neighbors);
                      });
  return Select(voxels, [&](std::size_t i) { return keep[i] != 0; });
}

Surface FitSurface(const SortedVoxels& voxels,
                   double voxel_size_m,
                   double radius_m,
                   bool project,
                   int num_threads) {
  Surface surface{voxels.sums, std::vector<float>(voxels.sums.size(), -1)};
  const std::vector<Eigen::Vector3d> positions = Positions(voxels.sums);
  ForEachNeighborhood(voxels.keys,
                      positions,
                      voxel_size_m,
                      radius_m,
                      num_threads,
                      [&](std::size_t i, const std::vector<Neighbor>& neighbors) {
                        if (neighbors.size() < kMinNeighbors) {
                          surface.points[i].direction.normalize();
                          return;
                        }
                        const Plane plane =
                            FitPlane(voxels.sums, positions, i, neighbors, radius_m);
                        surface.points[i] = OntoPlane(voxels.sums[i], plane, project);
                        if (plane.IsFlat()) {
                          surface.thickness_m[i] = static_cast<float>(std::sqrt(plane.variance_m2));
                        }
                      });
  return surface;
}

}  // namespace nightmap
