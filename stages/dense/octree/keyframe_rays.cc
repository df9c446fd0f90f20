// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/keyframe_rays.h"

#include "pipeline/base/error.h"

namespace nightmap {

CloudSupport::CloudSupport(const std::vector<CloudPoint>& cloud,
                           double resolution_m,
                           double reach_m)
    : resolution_m_(resolution_m) {
  BlockMap<BlockBits> done;
  for (const CloudPoint& point : cloud) {
    if (!(point.position_in_map.cwiseAbs().maxCoeff() < reach_m)) {
      throw DataError(
          "the cloud has a point beyond the octree's reach of {} m; cloud and keyframes must "
          "be of one run, or take a larger octree.resolution_m",
          reach_m);
    }
    const VoxelKey key = VoxelOf(point.position_in_map.cast<double>(), resolution_m);
    const std::uint64_t voxel = MortonCode(key);
    if (!done.At(BlockOf(voxel)).Insert(IndexInBlock(voxel))) continue;
    for (int i = 0; i < 27; ++i) {
      const auto near = MortonCode(key + VoxelKey(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1));
      voxels_.At(BlockOf(near)).Set(IndexInBlock(near));
    }
  }
}

bool CloudSupport::Holds(const Eigen::Vector3d& point_in_map) const {
  const std::uint64_t voxel = MortonCode(VoxelOf(point_in_map, resolution_m_));
  const BlockBits* block = voxels_.Find(BlockOf(voxel));
  return block != nullptr && block->Test(IndexInBlock(voxel));
}

SupportedRays MakeKeyframeRays(const std::vector<DepthPoint>& points,
                               const Rigid3& map_from_camera,
                               double margin_sigmas,
                               double max_range_m,
                               const CloudSupport* support) {
  SupportedRays result;
  result.rays.origin_in_map = map_from_camera.translation;
  result.rays.points.reserve(points.size());
  for (const DepthPoint& point : points) {
    const Eigen::Vector3d point_in_camera = point.point_in_camera.cast<double>();
    const Eigen::Vector3d point_in_map = map_from_camera * point_in_camera;
    const bool in_range = point_in_camera.squaredNorm() <= max_range_m * max_range_m;
    if (in_range && support != nullptr && !support->Holds(point_in_map)) {
      ++result.num_unsupported;
      continue;
    }
    result.rays.points.push_back({point_in_map, margin_sigmas * point.sigma_m, point.rgb});
  }
  return result;
}

}  // namespace nightmap
