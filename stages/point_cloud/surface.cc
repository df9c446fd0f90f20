// SPDX-License-Identifier: Apache-2.0
#include "stages/point_cloud/surface.h"

#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Eigenvalues>

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

// A plane's neighbourhood spreads in two directions; above this share of variance along the normal
// it is an edge or a corner, which projection would round off.
constexpr double kMaxFlatVariation = 0.1;
constexpr std::size_t kMinNeighbors = 5;

PclCloud::Ptr ToPcl(const std::vector<VoxelSum>& points) {
  auto cloud = std::make_shared<PclCloud>();
  cloud->reserve(points.size());
  for (const VoxelSum& point : points) {
    const Eigen::Vector3f position = point.Position().cast<float>();
    cloud->push_back({position.x(), position.y(), position.z()});
  }
  return cloud;
}

struct Plane {
  Eigen::Vector3d centre;
  Eigen::Vector3d normal;
  double variation = 1;  // smallest eigenvalue over their sum: 0 flat, 1/3 shapeless
};

Plane FitPlane(const std::vector<VoxelSum>& points,
               const pcl::Indices& neighbors,
               const std::vector<float>& squared_distances,
               double radius_m) {
  const Eigen::Vector3d origin = points[static_cast<std::size_t>(neighbors[0])].Position();
  double total = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < neighbors.size(); ++i) {
    const VoxelSum& point = points[static_cast<std::size_t>(neighbors[i])];
    const double closeness = 1 - squared_distances[i] / (radius_m * radius_m);
    const double weight = point.weight * std::max(0.0, closeness);
    const Eigen::Vector3d offset = point.Position() - origin;
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
          trace > 0 ? solver.eigenvalues()[0] / trace : 1.0};
}

VoxelSum OntoPlane(VoxelSum point, const Plane& plane, bool project) {
  const float side = plane.normal.dot(point.direction.cast<double>()) < 0 ? -1.0F : 1.0F;
  point.direction = side * plane.normal.cast<float>();
  if (project && plane.variation < kMaxFlatVariation) {
    const Eigen::Vector3d position = point.Position();
    const double distance_m = plane.normal.dot(plane.centre - position);
    point.weighted_position = point.weight * (position + distance_m * plane.normal);
  }
  return point;
}

}  // namespace

std::vector<VoxelSum> RemoveOutliers(const std::vector<VoxelSum>& points,
                                     int num_neighbors,
                                     double max_deviations) {
  if (points.size() <= static_cast<std::size_t>(num_neighbors)) return points;
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setInputCloud(ToPcl(points));
  filter.setMeanK(num_neighbors);
  filter.setStddevMulThresh(max_deviations);
  pcl::Indices kept_indices;
  filter.filter(kept_indices);
  std::vector<VoxelSum> kept;
  kept.reserve(kept_indices.size());
  for (const int index : kept_indices) kept.push_back(points[static_cast<std::size_t>(index)]);
  return kept;
}

std::vector<VoxelSum> FitSurface(const std::vector<VoxelSum>& points,
                                 double radius_m,
                                 bool project,
                                 int num_threads) {
  std::vector<VoxelSum> fitted = points;
  if (points.empty()) return fitted;
  const PclCloud::Ptr cloud = ToPcl(points);
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setInputCloud(cloud);
  constexpr std::size_t kChunk = 1024;
  ParallelFor((points.size() + kChunk - 1) / kChunk, num_threads, [&](std::size_t chunk) {
    pcl::Indices neighbors;
    std::vector<float> squared_distances;
    for (std::size_t i = chunk * kChunk; i < std::min(points.size(), (chunk + 1) * kChunk); ++i) {
      tree.radiusSearch((*cloud)[i], radius_m, neighbors, squared_distances);
      if (neighbors.size() >= kMinNeighbors) {
        fitted[i] =
            OntoPlane(points[i], FitPlane(points, neighbors, squared_distances, radius_m), project);
      } else {
        fitted[i].direction.normalize();
      }
    }
  });
  return fitted;
}

}  // namespace nightmap
