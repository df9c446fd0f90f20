// SPDX-License-Identifier: Apache-2.0
// The filters of point_cloud against PCL's, from the points of the map's keyframes on.
#include <fmt/format.h>
#include <pcl/features/normal_3d_omp.h>
#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <unordered_set>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/voxel_key.h"
#include "stages/point_cloud/point_cloud.h"
#include "stages/point_cloud/surface.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"

namespace nightmap {
namespace {

constexpr std::size_t kNumKeyframes = 24;

using ColorCloud = pcl::PointCloud<pcl::PointXYZRGB>;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

// The pixels of one keyframe as the stage takes them.
std::vector<VoxelSum> LoadPoints(const MappedSite& site,
                                 const Keyframe& keyframe,
                                 const PointCloudOptions& options) {
  const RgbdImages images = site.keyframes.load(keyframe);
  const RgbdCamera& camera = site.CameraOf(keyframe.frame.frame_idx);
  std::vector<VoxelSum> points;
  for (const DepthPoint& point : BackProjectDepth(images.depth,
                                                  images.color,
                                                  MakeRayTable(camera.color, 1),
                                                  camera,
                                                  options.max_depth_m,
                                                  options.depth_filter)) {
    const Eigen::Vector3d position =
        keyframe.map_from_camera * point.point_in_camera.cast<double>();
    VoxelSum sum;
    sum.weight = 1.0 / (static_cast<double>(point.sigma_m) * point.sigma_m);
    sum.weighted_position = sum.weight * position;
    sum.direction = (keyframe.map_from_camera.translation - position).normalized().cast<float>();
    for (int k = 0; k < 3; ++k) sum.color[k] = point.rgb[static_cast<std::size_t>(k)];
    sum.num_points = 1;
    points.push_back(sum);
  }
  return points;
}

pcl::PointXYZ ToPcl(const Eigen::Vector3d& position) {
  const Eigen::Vector3f single = position.cast<float>();
  return {single.x(), single.y(), single.z()};
}

Cloud::Ptr ToPcl(const SortedVoxels& voxels) {
  auto cloud = std::make_shared<Cloud>();
  for (const Eigen::Vector3d& position : Positions(voxels.sums)) cloud->push_back(ToPcl(position));
  return cloud;
}

using Keyframes = std::vector<std::vector<VoxelSum>>;

ColorCloud::Ptr AllPoints(const Keyframes& keyframes) {
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

// As the stage: a sum per keyframe, which several threads make, and then their sum in order.
SortedVoxels Fuse(const Keyframes& keyframes, const PointCloudOptions& options, int num_threads) {
  std::vector<VoxelSums> sums(keyframes.size());
  ParallelFor(keyframes.size(), num_threads, [&](std::size_t i) {
    sums[i].reserve(keyframes[i].size() / 4);
    for (const VoxelSum& point : keyframes[i]) AddPoint(point, options.voxel_size_m, sums[i]);
  });
  VoxelSums all;
  for (const VoxelSums& of_keyframe : sums) MergeSums(of_keyframe, all);
  return SortVoxels(all, options.min_observations);
}

std::string VoxelDifference(const SortedVoxels& ours, const ColorCloud& theirs, double voxel_m) {
  std::size_t num_same = 0;
  double sum_m = 0;
  for (const auto& point : theirs) {
    const Eigen::Vector3d position = point.getVector3fMap().cast<double>();
    const auto found = std::ranges::lower_bound(ours.keys, PackVoxel(VoxelOf(position, voxel_m)));
    if (found == ours.keys.end() || *found != PackVoxel(VoxelOf(position, voxel_m))) continue;
    ++num_same;
    sum_m += (ours.sums[static_cast<std::size_t>(found - ours.keys.begin())].Position() - position)
                 .norm();
  }
  return fmt::format("{} and {} points, {} voxels the same, there {:.2f} mm apart in the mean",
                     ours.keys.size(),
                     theirs.size(),
                     num_same,
                     1e3 * sum_m / static_cast<double>(std::max<std::size_t>(1, num_same)));
}

SortedVoxels CompareVoxelFilter(const std::string& name,
                                const Keyframes& keyframes,
                                const PointCloudOptions& options) {
  const ColorCloud::Ptr all = AllPoints(keyframes);
  SortedVoxels ours;
  ColorCloud theirs;
  PrintComparison(
      {.ours = "`VoxelSums`",
       .other = "`pcl::VoxelGrid`",
       .input = fmt::format("{}: {} points of {} keyframes", name, all->size(), keyframes.size()),
       .run_ours = [&](int num_threads) { ours = Fuse(keyframes, options, num_threads); },
       .run_other =
           [&](int) {
             pcl::VoxelGrid<pcl::PointXYZRGB> filter;
             const auto edge_m = static_cast<float>(options.voxel_size_m);
             filter.setLeafSize(edge_m, edge_m, edge_m);
             filter.setMinimumPointsNumberPerVoxel(static_cast<unsigned>(options.min_observations));
             filter.setInputCloud(all);
             filter.filter(theirs);
           },
       .difference = [&] { return VoxelDifference(ours, theirs, options.voxel_size_m); }});
  return ours;
}

void CompareOutlierFilter(const std::string& name,
                          const SortedVoxels& voxels,
                          const PointCloudOptions& options) {
  const Cloud::Ptr cloud = ToPcl(voxels);
  const double radius_m = options.outlier_radius_voxels * options.voxel_size_m;
  SortedVoxels ours;
  pcl::Indices theirs;
  PrintComparison(
      {.ours = "`RemoveOutliers`",
       .other = "`pcl::RadiusOutlierRemoval`",
       .input = fmt::format("{}: {} points", name, cloud->size()),
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

void CompareNormals(const std::string& name,
                    const SortedVoxels& voxels,
                    const PointCloudOptions& options) {
  const Cloud::Ptr cloud = ToPcl(voxels);
  Surface ours;
  pcl::PointCloud<pcl::Normal> theirs;
  PrintComparison(
      {.ours = "`FitSurface`",
       .other = "`pcl::NormalEstimationOMP`",
       .input = fmt::format("{}: {} points", name, cloud->size()),
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
             std::vector<double> degrees;
             for (std::size_t i = 0; i < ours.points.size(); ++i) {
               const Eigen::Vector3f normal = theirs[i].getNormalVector3fMap();
               if (!normal.allFinite()) continue;
               const float cosine = std::abs(normal.dot(ours.points[i].direction));
               degrees.push_back(std::acos(std::min(1.0, static_cast<double>(cosine))) * 180 /
                                 M_PI);
             }
             std::ranges::sort(degrees);
             return fmt::format("normals {:.1f}° apart in the median", degrees[degrees.size() / 2]);
           }});
}

}  // namespace

void CompareClouds(const MappedSite& site) {
  const PointCloudOptions options;
  Keyframes keyframes;
  for (const Keyframe& keyframe : EvenlySpaced(site.keyframes.keyframes, kNumKeyframes)) {
    keyframes.push_back(LoadPoints(site, keyframe, options));
  }
  const SortedVoxels voxels = CompareVoxelFilter(site.name, keyframes, options);
  CompareOutlierFilter(site.name, voxels, options);
  CompareNormals(site.name, voxels, options);
}

}  // namespace nightmap
