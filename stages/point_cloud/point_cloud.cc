// SPDX-License-Identifier: Apache-2.0
#include "stages/point_cloud/point_cloud.h"

#include "pipeline/base/error.h"
#include "pipeline/geometry/voxel_key.h"
#include "stages/point_cloud/surface.h"
#include "stages/point_cloud/voxel_filter.h"

namespace nightmap {
namespace {

VoxelSum ToSum(const DepthPoint& point, const Rigid3& map_from_camera) {
  const Eigen::Vector3d position = map_from_camera * point.point_in_camera.cast<double>();
  VoxelSum sum;
  sum.weight = 1.0 / (static_cast<double>(point.sigma_m) * point.sigma_m);
  sum.weighted_position = sum.weight * position;
  sum.direction = (map_from_camera.translation - position).normalized().cast<float>();
  sum.color = {static_cast<float>(point.rgb[0]),
               static_cast<float>(point.rgb[1]),
               static_cast<float>(point.rgb[2])};
  sum.num_points = 1;
  return sum;
}

VoxelSums FuseFrame(const PointCloudOptions& options,
                    const RgbdCamera& camera,
                    const RayTable& rays,
                    const Keyframe& keyframe,
                    const RgbdImages& images) {
  VoxelSums sums;
  for (const DepthPoint& point : BackProjectDepth(
           images.depth, images.color, rays, camera, options.max_depth_m, options.depth_filter)) {
    AddPoint(ToSum(point, keyframe.map_from_camera), options.voxel_size_m, sums);
  }
  return sums;
}

// All keyframes fused; the reasons of skipped ones go to `result`.
VoxelSums FuseAll(const PointCloudOptions& options,
                  const KeyframeSource& source,
                  Progress& progress,
                  int num_threads,
                  PointCloudResult& result) {
  const std::vector<RayTable> rays = MakeRayTables(source.cameras, num_threads);
  VoxelSums all;
  result.skipped = FuseKeyframes<VoxelSums>(
      source,
      progress,
      num_threads,
      [&](const Keyframe& keyframe, const RgbdImages& images) {
        const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
        return FuseFrame(options, source.cameras[camera], rays[camera], keyframe, images);
      },
      [&](VoxelSums&& sums) { MergeSums(sums, all); });
  for (const auto& [key, sum] : all) result.num_measurements += sum.num_points;
  return all;
}

CloudPoint ToCloudPoint(const VoxelSum& sum) {
  CloudPoint point;
  point.position_in_map = sum.Position().cast<float>();
  point.normal_in_map = sum.direction.normalized();
  const Eigen::Array3f color = (sum.color / static_cast<float>(sum.num_points) + 0.5F).floor();
  for (int channel = 0; channel < 3; ++channel) {
    point.rgb[static_cast<std::size_t>(channel)] = static_cast<std::uint8_t>(color[channel]);
  }
  return point;
}

// Projection may bring two layers of one surface together in a voxel.
std::vector<CloudPoint> ThinToVoxels(const std::vector<VoxelSum>& surface, double voxel_size_m) {
  VoxelSums sums;
  for (const VoxelSum& point : surface) AddPoint(point, voxel_size_m, sums);
  std::vector<CloudPoint> points;
  for (const VoxelSum& voxel : SortedVoxels(sums, 1)) points.push_back(ToCloudPoint(voxel));
  return points;
}

}  // namespace

void PointCloudOptions::Register(OptionList& list) {
  list.Add("keyframe_stride", &keyframe_stride, Range(1, 1000), "uses every Nth keyframe");
  list.Add("max_depth_m", &max_depth_m, Range(0.1, 100.0), "farther depth is not used");
  depth_filter.Register(list);
  list.Add("voxel_size_m",
           &voxel_size_m,
           Range(0.002, 1.0),
           "at most one point in a voxel of this edge");
  list.Add("min_observations", &min_observations, Range(1, 10000), "depth pixels a voxel needs");
  list.Add("outlier_neighbors",
           &outlier_neighbors,
           Range(0, 200),
           "neighbours of the statistical outlier test; 0 keeps outliers");
  list.Add("outlier_deviations",
           &outlier_deviations,
           Range(0.1, 100.0),
           "an outlier's mean neighbour distance, in standard deviations above the mean");
  list.Add("surface_radius_m",
           &surface_radius_m,
           Range(0.005, 2.0),
           "neighbourhood of a point for its normal and projection");
  list.Add("project_to_surface",
           &project_to_surface,
           "moves points onto the plane of their neighbourhood");
  list.Add("max_failed_ratio",
           &max_failed_ratio,
           Range(0.0, 1.0),
           "share of unreadable keyframes above which the stage fails");
}

PointCloudResult RunPointCloud(const PointCloudOptions& options,
                               const KeyframeSource& source,
                               Progress& progress,
                               int num_threads) {
  CheckReach(source.keyframes, options.max_depth_m, options.voxel_size_m * kVoxelKeyReach);
  PointCloudResult result;
  std::vector<VoxelSum> voxels = SortedVoxels(
      FuseAll(options, source, progress, num_threads, result), options.min_observations);
  if (voxels.empty()) {
    throw DataError(
        "{}: no depth within {} m here and in all {} keyframes ({} unreadable, {} pixels used); "
        "look at the image, check depth_units_per_m of the site's cameras, or raise "
        "point_cloud.max_depth_m",
        source.keyframes.front().frame.depth_path,
        options.max_depth_m,
        source.keyframes.size(),
        result.skipped.size(),
        result.num_measurements);
  }
  result.num_voxels = voxels.size();
  if (options.outlier_neighbors > 0) {
    voxels = RemoveOutliers(voxels, options.outlier_neighbors, options.outlier_deviations);
  }
  result.num_outliers = result.num_voxels - voxels.size();
  voxels = FitSurface(voxels, options.surface_radius_m, options.project_to_surface, num_threads);
  result.points = ThinToVoxels(voxels, options.voxel_size_m);
  return result;
}

}  // namespace nightmap
