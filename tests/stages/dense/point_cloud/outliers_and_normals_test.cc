// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/outliers_and_normals.h"

#include <gtest/gtest.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "pipeline/base/random.h"
#include "pipeline/geometry/voxel_key.h"
#include "stages/dense/point_cloud/radius_neighbors.h"

namespace nightmap::outliers_and_normals_test {

constexpr double kVoxel_m = 0.02;

SortedVoxels ToVoxels(const std::vector<Eigen::Vector3d>& points) {
  VoxelSums sums;
  for (const Eigen::Vector3d& point : points) {
    VoxelSum sum;
    sum.weighted_position = point;
    sum.weight = 1;
    sum.direction = Eigen::Vector3f::UnitZ();
    sum.num_points = 1;
    AddPoint(sum, kVoxel_m, sums);
  }
  return SortVoxels(sums, 1);
}

// A patch of the plane z = 0 around (x_m, 0), every point off it by sigma_m.
void AddPatch(double x_m, double sigma_m, std::vector<Eigen::Vector3d>& points) {
  Random random(4, static_cast<std::uint64_t>(1000 * x_m));
  for (double x = -0.3; x < 0.3; x += 0.01) {
    for (double y = -0.3; y < 0.3; y += 0.01) {
      points.emplace_back(x_m + x, y, 0.01 + sigma_m * random.Gaussian());
    }
  }
}

TEST(Neighborhoods, AreThoseOfBruteForceInTheOrderOfVoxels) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 1500; ++i) {
    Random random(9, static_cast<std::uint64_t>(i));
    points.emplace_back(
        random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2));
  }
  const SortedVoxels voxels = ToVoxels(points);
  const auto positions = Positions(voxels.sums);
  for (const double radius_m : {0.019, 0.04, 0.071}) {
    std::vector<int> num_visits(positions.size());
    ForEachNeighborhood(
        voxels.keys, positions, kVoxel_m, radius_m, 2, [&](std::size_t i, const auto& neighbors) {
          ++num_visits[i];
          std::vector<std::size_t> expected, found;
          for (std::size_t j = 0; j < positions.size(); ++j) {
            if ((positions[j] - positions[i]).norm() < radius_m) expected.push_back(j);
          }
          for (const Neighbor& neighbor : neighbors) found.push_back(neighbor.index);
          EXPECT_EQ(found, expected);
        });
    EXPECT_EQ(num_visits, std::vector<int>(positions.size(), 1));
  }
}

TEST(Neighborhoods, AreThoseOfPclsKdTree) {
  auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  std::vector<Eigen::Vector3d> points;
  AddPatch(0.7, 0.02, points);
  const SortedVoxels voxels = ToVoxels(points);
  const auto positions = Positions(voxels.sums);
  for (const Eigen::Vector3d& point : positions) {
    cloud->push_back(pcl::PointXYZ(static_cast<float>(point.x()),
                                   static_cast<float>(point.y()),
                                   static_cast<float>(point.z())));
  }
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setInputCloud(cloud);
  // A radius that no two points have between them, to single precision.
  const double radius_m = 0.0712345;
  ForEachNeighborhood(
      voxels.keys, positions, kVoxel_m, radius_m, 1, [&](std::size_t i, const auto& neighbors) {
        pcl::Indices indices;
        std::vector<float> squared_distances;
        tree.radiusSearch((*cloud)[i], radius_m, indices, squared_distances);
        std::ranges::sort(indices);
        pcl::Indices found;
        for (const Neighbor& neighbor : neighbors)
          found.push_back(static_cast<int>(neighbor.index));
        EXPECT_EQ(found, indices);
      });
}

TEST(RemoveOutliers, DropsWhatFloatsBesideASurface) {
  std::vector<Eigen::Vector3d> points;
  AddPatch(0, 0, points);
  const std::size_t num_surface = ToVoxels(points).keys.size();
  for (int i = 0; i < 20; ++i) points.emplace_back(0.03 * i - 0.3, 0.1, 0.15 + 0.01 * (i % 2));
  const SortedVoxels kept = RemoveOutliers(ToVoxels(points), kVoxel_m, 3 * kVoxel_m, 8, 2);
  EXPECT_EQ(kept.keys.size(), num_surface);
  for (const VoxelSum& sum : kept.sums) EXPECT_LT(sum.Position().z(), 0.1);
}

TEST(RemoveOutliers, DoesNotDependOnWhatElseIsInTheCloud) {
  std::vector<Eigen::Vector3d> sparse, both;
  for (double x = -0.3; x < 0.3; x += 0.04) {
    for (double y = -0.3; y < 0.3; y += 0.04) sparse.emplace_back(x, y, 0.5);
  }
  both = sparse;
  AddPatch(5, 0, both);
  const auto count = [](const std::vector<Eigen::Vector3d>& points) {
    const auto kept = RemoveOutliers(ToVoxels(points), kVoxel_m, 3 * kVoxel_m, 4, 2);
    return std::ranges::count_if(kept.sums,
                                 [](const auto& sum) { return sum.Position().z() > 0.4; });
  };
  EXPECT_GT(count(sparse), 0);
  EXPECT_EQ(count(sparse), count(both));
}

double MedianThickness_m(const std::vector<Eigen::Vector3d>& points) {
  std::vector<float> thickness_m =
      FitSurface(ToVoxels(points), kVoxel_m, 0.08, true, 2).thickness_m;
  std::erase_if(thickness_m, [](float value) { return value < 0; });
  std::ranges::sort(thickness_m);
  return thickness_m.empty() ? -1 : thickness_m[thickness_m.size() / 2];
}

TEST(FitSurface, ThicknessIsTheNoiseOfThePlane) {
  std::vector<Eigen::Vector3d> flat, noisy, doubled;
  AddPatch(0, 0, flat);
  AddPatch(0, 0.003, noisy);
  AddPatch(0, 0, doubled);
  for (Eigen::Vector3d point : flat) doubled.push_back(point + Eigen::Vector3d(0, 0, 0.02));
  EXPECT_LT(MedianThickness_m(flat), 1e-6);
  // A voxel's position is the mean of four points.
  EXPECT_NEAR(MedianThickness_m(noisy), 0.0015, 0.0005);
  EXPECT_NEAR(MedianThickness_m(doubled), 0.01, 0.001);
}

}  // namespace nightmap::outliers_and_normals_test
