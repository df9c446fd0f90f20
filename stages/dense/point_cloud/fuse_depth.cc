// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/fuse_depth.h"

#include "pipeline/base/random.h"

namespace nightmap {
namespace {

constexpr int kRaysPerKeyframe = 32;

struct FusedFrame {
  VoxelSums sums;
  std::vector<HeldOutRay> rays;
};

std::uint8_t FoldOf(const PointCloudOptions& options, const Keyframe& keyframe) {
  return static_cast<std::uint8_t>(1
                                   << keyframe.keyframe_idx / options.keyframe_stride % kNumFolds);
}

VoxelSum ToSum(const DepthPoint& point,
               const Eigen::Vector3d& position,
               const Rigid3& map_from_camera,
               std::uint8_t fold) {
  VoxelSum sum;
  sum.weight = 1.0 / (static_cast<double>(point.sigma_m) * point.sigma_m);
  sum.weighted_position = sum.weight * position;
  sum.direction = (map_from_camera.translation - position).normalized().cast<float>();
  sum.color = {static_cast<float>(point.rgb[0]),
               static_cast<float>(point.rgb[1]),
               static_cast<float>(point.rgb[2])};
  sum.num_points = 1;
  sum.folds = fold;
  return sum;
}

// Draws the same rays whatever the region is, apart from those that end outside it.
std::vector<HeldOutRay> DrawRays(const PointCloudOptions& options,
                                 const Keyframe& keyframe,
                                 const std::vector<DepthPoint>& points,
                                 const Rectangle& inside) {
  std::vector<HeldOutRay> rays;
  Random random(0, static_cast<std::uint64_t>(keyframe.keyframe_idx));
  for (int i = 0; i < kRaysPerKeyframe && !points.empty(); ++i) {
    const DepthPoint& point = points[random.Index(points.size())];
    const Rigid3& pose = keyframe.map_from_camera;
    const Eigen::Vector3d end = pose * point.point_in_camera.cast<double>();
    if (!inside.Contains(end.head<2>())) continue;
    rays.push_back({pose.translation,
                    end,
                    DepthTolerance_m(options, point.sigma_m),
                    FoldOf(options, keyframe)});
  }
  return rays;
}

FusedFrame FuseFrame(const PointCloudOptions& options,
                     const RgbdCamera& camera,
                     const RayTable& rays,
                     const MapRegion& region,
                     const Keyframe& keyframe,
                     const RgbdImages& images) {
  FusedFrame fused;
  const Rectangle seen = region.inside.Grown(region.overlap_m);
  const Rigid3& pose = keyframe.map_from_camera;
  const auto points = BackProjectDepth(
      images.depth, images.color, rays, camera, options.max_depth_m, options.depth_filter);
  const std::uint8_t fold = FoldOf(options, keyframe);
  fused.sums.reserve(points.size() / 4);
  for (const DepthPoint& point : points) {
    const Eigen::Vector3d position = pose * point.point_in_camera.cast<double>();
    if (!seen.Contains(position.head<2>())) continue;
    AddPoint(ToSum(point, position, pose, fold), options.voxel_size_m, fused.sums);
  }
  fused.rays = DrawRays(options, keyframe, points, region.inside);
  return fused;
}

}  // namespace

double DepthTolerance_m(const PointCloudOptions& options, double sigma_m) {
  return options.consistency_sigmas * sigma_m + options.voxel_size_m;
}

FusedDepth FuseDepth(const PointCloudOptions& options,
                     const KeyframeSource& source,
                     Progress& progress,
                     int num_threads) {
  const std::vector<RayTable> rays = MakeRayTables(source.cameras, num_threads);
  FusedDepth all;
  all.skipped = FuseKeyframes<FusedFrame>(
      source,
      progress,
      num_threads,
      [&](const Keyframe& keyframe, const RgbdImages& images) {
        const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
        return FuseFrame(
            options, source.cameras[camera], rays[camera], source.region, keyframe, images);
      },
      [&](FusedFrame&& frame) {
        MergeSums(frame.sums, all.sums);
        all.rays.insert(all.rays.end(), frame.rays.begin(), frame.rays.end());
      });
  return all;
}

}  // namespace nightmap
