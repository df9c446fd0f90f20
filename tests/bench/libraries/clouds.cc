// SPDX-License-Identifier: Apache-2.0
// The filters of point_cloud against PCL's, from the points of keyframes on.
#include <fmt/format.h>
#include <pcl/features/normal_3d_omp.h>
#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <unordered_set>

#include "pipeline/geometry/voxel_key.h"
#include "stages/dense/point_cloud/outliers_and_normals.h"
#include "stages/dense/point_cloud/point_cloud.h"
#include "tests/bench/libraries/cloud_input.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"

namespace nightmap {
namespace {

using ColorCloud = pcl::PointCloud<pcl::PointXYZRGB>;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

pcl::PointXYZ ToPcl(const Eigen::Vector3d& position) {
  const Eigen::Vector3f single = position.cast<float>();
  return {single.x(), single.y(), single.z()};
}

Cloud::Ptr ToPcl(const SortedVoxels& voxels) {
  auto cloud = std::make_shared<Cloud>();
  for (const Eigen::Vector3d& position : Positions(voxels.sums)) cloud->push_back(ToPcl(position));
  return cloud;
}

ColorCloud::Ptr AllPoints(const DepthPoints& keyframes) {
  auto cloud = std::make_shared<ColorCloud>();
  for (const auto& points : keyframes) {
    for (const VoxelSum& point : points) {
      pcl::PointXYZRGB converted;
      converted.getVector3fMap() = point.Position().cast<float>();
      converted.r = static_cast<std::uint8_t>(point.color[0]);
      converted.g = static_cast<std::uint8_t>(point.color[1]);
      converted.b = static_cast<std::uint8_t>(point.color[2]);
      cloud->push_back(converted);
    }
  }
  return cloud;
}

std::string VoxelDifference(const CloudInput& input,
                            const SortedVoxels& ours,
                            const ColorCloud& theirs,
                            double voxel_m) {
  std::size_t num_same = 0;
  double sum_m = 0;
  std::vector<Eigen::Vector3d> positions;
  for (const auto& point : theirs) {
    const Eigen::Vector3d position = point.getVector3fMap().cast<double>();
    positions.push_back(position);
    const auto found = std::ranges::lower_bound(ours.keys, PackVoxel(VoxelOf(position, voxel_m)));
    if (found == ours.keys.end() || *found != PackVoxel(VoxelOf(position, voxel_m))) continue;
    ++num_same;
    sum_m += (ours.sums[static_cast<std::size_t>(found - ours.keys.begin())].Position() - position)
                 .norm();
  }
  if (input.room) {
    return fmt::format("RMS distance to the walls {:.2f} mm and {:.2f} mm",
                       RmsDistance_mm(*input.room, Positions(ours.sums)),
                       RmsDistance_mm(*input.room, positions));
  }
  return fmt::format("{} and {} points, {} voxels the same, there {:.2f} mm apart in the mean",
                     ours.keys.size(),
                     theirs.size(),
                     num_same,
                     1e3 * sum_m / static_cast<double>(std::max<std::size_t>(1, num_same)));
}

SortedVoxels CompareVoxelFilter(const CloudInput& input, const PointCloudOptions& options) {
  const ColorCloud::Ptr all = AllPoints(input.keyframes);
  SortedVoxels ours;
  ColorCloud theirs;
  PrintComparison(
      {.ours = "`VoxelSums`",
       .other = "`pcl::VoxelGrid`",
       .input = fmt::format(
           "{}: {} points of {} keyframes", input.name, all->size(), input.keyframes.size()),
       .run_ours = [&](int num_threads) { ours = Fuse(input.keyframes, options, num_threads); },
       .run_other =
           [&](int) {
             pcl::VoxelGrid<pcl::PointXYZRGB> filter;
             const auto edge_m = static_cast<float>(options.voxel_size_m);
             filter.setLeafSize(edge_m, edge_m, edge_m);
             filter.setMinimumPointsNumberPerVoxel(static_cast<unsigned>(options.min_observations));
             filter.setInputCloud(all);
             filter.filter(theirs);
           },
       .difference = [&] { return VoxelDifference(input, ours, theirs, options.voxel_size_m); }});
  return ours;
}

void CompareOutlierFilter(const CloudInput& input,
                          const SortedVoxels& voxels,
                          const PointCloudOptions& options) {
  const Cloud::Ptr cloud = ToPcl(voxels);
  const double radius_m = options.outlier_radius_voxels * options.voxel_size_m;
  SortedVoxels ours;
  pcl::Indices theirs;
  PrintComparison(
      {.ours = "`RemoveOutliers`",
       .other = "`pcl::RadiusOutlierRemoval`",
       .input = fmt::format("{}: {} points", input.name, cloud->size()),
       .run_ours =
           [&](int num_threads) {
             ours = RemoveOutliers(voxels,
                                   options.voxel_size_m,
                                   radius_m,
                                   options.outlier_min_neighbors,
                                   num_threads);
           },
       .run_other =
           [&](int) {
             pcl::RadiusOutlierRemoval<pcl::PointXYZ> filter;
             filter.setRadiusSearch(radius_m);
             filter.setMinNeighborsInRadius(options.outlier_min_neighbors);
             filter.setInputCloud(cloud);
             filter.filter(theirs);
           },
       .difference =
           [&] {
             const std::unordered_set<std::uint64_t> kept(ours.keys.begin(), ours.keys.end());
             const auto num_both = std::ranges::count_if(theirs, [&](int i) {
               return kept.contains(voxels.keys[static_cast<std::size_t>(i)]);
             });
             return fmt::format(
                 "{} and {} points kept, {} the same", kept.size(), theirs.size(), num_both);
           }});
}

double Angle_deg(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::acos(std::min(1.0, static_cast<double>(std::abs(a.dot(b))))) * 180 / M_PI;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

using Normals = pcl::PointCloud<pcl::Normal>;

double MedianAngle_deg(const Surface& ours, const Normals& theirs) {
  std::vector<double> angles_deg;
  for (std::size_t i = 0; i < ours.points.size(); ++i) {
    const Eigen::Vector3f normal = theirs[i].getNormalVector3fMap();
    if (normal.allFinite()) angles_deg.push_back(Angle_deg(normal, ours.points[i].direction));
  }
  return Median(angles_deg);
}

std::string NormalErrors(const BoxRoom& room,
                         const SortedVoxels& voxels,
                         const Surface& ours,
                         const Normals& theirs) {
  const std::vector<Eigen::Vector3d> positions = Positions(voxels.sums);
  std::vector<double> of_ours, of_theirs;
  for (std::size_t i = 0; i < ours.points.size(); ++i) {
    const Eigen::Vector3f wall = WallNormal(room, positions[i]);
    const Eigen::Vector3f normal = theirs[i].getNormalVector3fMap();
    if (!normal.allFinite()) continue;
    of_ours.push_back(Angle_deg(ours.points[i].direction, wall));
    of_theirs.push_back(Angle_deg(normal, wall));
  }
  return fmt::format(
      "normals {:.2f}° and {:.2f}° off the walls in the median; points {:.2f} mm RMS, before "
      "{:.2f} mm",
      Median(of_ours),
      Median(of_theirs),
      RmsDistance_mm(room, Positions(ours.points)),
      RmsDistance_mm(room, positions));
}

void CompareNormals(const CloudInput& input,
                    const SortedVoxels& voxels,
                    const PointCloudOptions& options) {
  const Cloud::Ptr cloud = ToPcl(voxels);
  Surface ours;
  pcl::PointCloud<pcl::Normal> theirs;
  PrintComparison(
      {.ours = "`FitSurface`",
       .other = "`pcl::NormalEstimationOMP`",
       .input = fmt::format("{}: {} points", input.name, cloud->size()),
       .run_ours =
           [&](int num_threads) {
             ours = FitSurface(
                 voxels, options.voxel_size_m, options.surface_radius_m, true, num_threads);
           },
       .run_other =
           [&](int num_threads) {
             pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> estimation(
                 static_cast<unsigned>(num_threads));
             estimation.setRadiusSearch(options.surface_radius_m);
             estimation.setInputCloud(cloud);
             estimation.compute(theirs);
           },
       .difference =
           [&] {
             if (input.room) return NormalErrors(*input.room, voxels, ours, theirs);
             return fmt::format("normals {:.1f}° apart in the median",
                                MedianAngle_deg(ours, theirs));
           }});
}

}  // namespace

void CompareClouds(const CloudInput& input) {
  const PointCloudOptions options;
  const SortedVoxels voxels = CompareVoxelFilter(input, options);
  CompareOutlierFilter(input, voxels, options);
  CompareNormals(input, voxels, options);
}

}  // namespace nightmap
