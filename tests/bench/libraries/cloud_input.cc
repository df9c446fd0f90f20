// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/libraries/cloud_input.h"

#include <cmath>

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

constexpr std::size_t kNumKeyframes = 24;

// The pixels of one keyframe as the stage takes them.
std::vector<VoxelSum> LoadPoints(const KeyframeSource& source,
                                 const Keyframe& keyframe,
                                 const PointCloudOptions& options) {
  const RgbdImages images = source.load(keyframe);
  const RgbdCamera& camera = source.cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)];
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

DepthPoints LoadAll(const KeyframeSource& source) {
  const PointCloudOptions options;
  DepthPoints keyframes;
  for (const Keyframe& keyframe : EvenlySpaced(source.keyframes, kNumKeyframes)) {
    keyframes.push_back(LoadPoints(source, keyframe, options));
  }
  return keyframes;
}

}  // namespace

CloudInput CloudOfSite(const MappedSite& site) {
  return {site.name, LoadAll(site.keyframes), std::nullopt};
}

CloudInput CloudOfBoxRoom() {
  const BoxRoom room;
  return {"box room", LoadAll(LookAround(room, kNumKeyframes)), room};
}

SortedVoxels Fuse(const DepthPoints& keyframes, const PointCloudOptions& options, int num_threads) {
  std::vector<VoxelSums> sums(keyframes.size());
  ParallelFor(keyframes.size(), num_threads, [&](std::size_t i) {
    sums[i].reserve(keyframes[i].size() / 4);
    for (const VoxelSum& point : keyframes[i]) AddPoint(point, options.voxel_size_m, sums[i]);
  });
  VoxelSums all;
  for (const VoxelSums& of_keyframe : sums) MergeSums(of_keyframe, all);
  return SortVoxels(all, options.min_observations);
}

double RmsDistance_mm(const BoxRoom& room, const std::vector<Eigen::Vector3d>& points) {
  double sum_m2 = 0;
  for (const Eigen::Vector3d& point : points) sum_m2 += std::pow(room.DistanceToWall_m(point), 2);
  return 1e3 * std::sqrt(sum_m2 / static_cast<double>(points.size()));
}

Eigen::Vector3f WallNormal(const BoxRoom& room, const Eigen::Vector3d& point) {
  int axis = 0;
  (point - room.min_m).cwiseAbs().cwiseMin((room.max_m - point).cwiseAbs()).minCoeff(&axis);
  return Eigen::Vector3f::Unit(axis);
}

}  // namespace nightmap
