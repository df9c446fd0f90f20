// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/point_cloud.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/dense/ply_io.h"
#include "pipeline/geometry/voxel_key.h"
#include "stages/dense/point_cloud/depth_consistency.h"
#include "stages/dense/point_cloud/fuse_depth.h"
#include "stages/dense/point_cloud/outliers_and_normals.h"

namespace nightmap {
namespace {

bool Owns(const MapRegion& region, const VoxelSum& sum) {
  return region.inside.Contains(sum.Position().head<2>());
}

std::size_t CountOwned(const MapRegion& region, const std::vector<VoxelSum>& sums) {
  return static_cast<std::size_t>(
      std::ranges::count_if(sums, [&](const VoxelSum& sum) { return Owns(region, sum); }));
}

std::size_t CountMeasurements(const MapRegion& region, const VoxelSums& sums) {
  std::size_t num_measurements = 0;
  for (const auto& [key, sum] : sums) {
    if (Owns(region, sum)) num_measurements += sum.num_points;
  }
  return num_measurements;
}

// Removes voxels that keyframes contradict, and outliers.
SortedVoxels CleanVoxels(const PointCloudOptions& options,
                         const KeyframeSource& source,
                         SortedVoxels voxels,
                         Progress& progress,
                         int num_threads,
                         PointCloudResult& result) {
  const auto count = [&](const SortedVoxels& some) { return CountOwned(source.region, some.sums); };
  result.num_voxels = count(voxels);
  if (options.min_consistent_frames > 0) {
    voxels = RemoveInconsistent(options, voxels, source, progress, num_threads);
  }
  const std::size_t num_consistent = count(voxels);
  result.num_inconsistent = result.num_voxels - num_consistent;
  if (options.outlier_min_neighbors > 0) {
    voxels = RemoveOutliers(voxels,
                            options.voxel_size_m,
                            options.outlier_radius_voxels * options.voxel_size_m,
                            options.outlier_min_neighbors,
                            num_threads);
  }
  result.num_outliers = num_consistent - count(voxels);
  return voxels;
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

// Projection may move two layers of one surface into the same voxel.
VoxelSums MergeToVoxels(const std::vector<VoxelSum>& surface, double voxel_size_m) {
  VoxelSums sums;
  for (const VoxelSum& point : surface) AddPoint(point, voxel_size_m, sums);
  return sums;
}

std::vector<CloudPoint> ToCloud(const VoxelSums& sums,
                                double voxel_size_m,
                                const Rectangle& inside) {
  std::vector<CloudPoint> points;
  for (const VoxelSum& voxel : SortVoxels(sums, 1).sums) {
    const CloudPoint point = ToCloudPoint(voxel);
    if (inside.Contains(point.position_in_map.head<2>().cast<double>())) points.push_back(point);
  }
  // Rounding to single precision may move a position across the border of its voxel.
  const auto by_voxel = [voxel_size_m](const CloudPoint& a, const CloudPoint& b) {
    return ByVoxel(a, b, voxel_size_m);
  };
  if (!std::ranges::is_sorted(points, by_voxel)) std::ranges::sort(points, by_voxel);
  return points;
}

// Quantiles of the flat points' thickness, in all and by place.
void MeasureThickness(const MapRegion& region,
                      const Surface& surface,
                      PointCloudResult& result,
                      PlaceQualities& places) {
  std::vector<float> values_m;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    if (surface.thickness_m[i] >= 0 && Owns(region, surface.points[i])) {
      values_m.push_back(surface.thickness_m[i]);
      places.AddFlat(surface.points[i].Position(), surface.thickness_m[i]);
    }
  }
  if (values_m.empty()) return;
  std::ranges::sort(values_m);
  result.plane_thickness_median_m = values_m[values_m.size() / 2];
  result.plane_thickness_p90_m = values_m[values_m.size() * 9 / 10];
}

// A point of the cloud depends on everything within this distance: it moved from a voxel whose
// plane was fitted to points that were no outliers, and each of these is the mean of a voxel.
void CheckOverlap(const PointCloudOptions& options, const MapRegion& region) {
  const double reach_m =
      2 * options.surface_radius_m + (options.outlier_radius_voxels + 2) * options.voxel_size_m;
  if (!region.inside.IsBounded() || reach_m <= region.overlap_m) return;
  throw UsageError(
      "points depend on what is up to {} m around them (2 surface_radius_m + "
      "(outlier_radius_voxels + 2) voxel_size_m), tiles overlap by {} m; raise tiles.overlap_m",
      reach_m,
      region.overlap_m);
}

}  // namespace

PointCloudResult RunPointCloud(const PointCloudOptions& options,
                               const KeyframeSource& source,
                               Progress& progress,
                               int num_threads) {
  CheckOverlap(options, source.region);
  CheckReach(source.keyframes, options.max_depth_m, options.voxel_size_m * kVoxelKeyReach);
  PointCloudResult result;
  FusedDepth fused = FuseDepth(options, source, progress, num_threads);
  result.skipped = std::move(fused.skipped);
  result.num_measurements = CountMeasurements(source.region, fused.sums);
  SortedVoxels voxels = SortVoxels(fused.sums, options.min_observations);
  fused.sums = VoxelSums();  // frees the largest array before others are made
  voxels = CleanVoxels(options, source, std::move(voxels), progress, num_threads, result);
  const Surface surface = FitSurface(voxels,
                                     options.voxel_size_m,
                                     options.surface_radius_m,
                                     options.project_to_surface,
                                     num_threads);
  PlaceQualities places;
  MeasureThickness(source.region, surface, result, places);
  const VoxelSums cloud = MergeToVoxels(surface.points, options.voxel_size_m);
  const auto ends = TestRays(fused.rays, cloud, options.voxel_size_m, num_threads);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    places.AddRay(fused.rays[i].end, ends[i] == RayEnd::kOnTheCloud);
  }
  result.held_out = AgreementOf(ends);
  result.places = places.Places();
  result.points = ToCloud(cloud, options.voxel_size_m, source.region.inside);
  return result;
}

}  // namespace nightmap
