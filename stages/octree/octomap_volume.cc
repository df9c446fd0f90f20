// SPDX-License-Identifier: Apache-2.0
#include "stages/octree/octomap_volume.h"

#include <octomap/OcTree.h>

#include "pipeline/dense/octree_leaves.h"

namespace nightmap {

class OctomapVolume::Tree : public octomap::OcTree {
 public:
  Tree(const SensorModel& model, double resolution_m) : OcTree(resolution_m) {
    prob_hit_log = model.hit;
    prob_miss_log = model.miss;
    clamping_thres_min = model.min;
    clamping_thres_max = model.max;
  }
};

OctomapVolume::OctomapVolume(const SensorModel& model, const TraceOptions& options)
    : options_(options), tree_(std::make_unique<Tree>(model, options.resolution_m)) {}

OctomapVolume::~OctomapVolume() = default;

void OctomapVolume::Insert(const KeyframeRays& rays) {
  const auto to_octomap = [](const Eigen::Vector3d& point) {
    return octomap::point3d(static_cast<float>(point.x()),
                            static_cast<float>(point.y()),
                            static_cast<float>(point.z()));
  };
  octomap::Pointcloud points;
  points.reserve(rays.points.size());
  for (const RayEnd& point : rays.points) points.push_back(to_octomap(point.point_in_map));
  constexpr bool kLazyEval = true;
  tree_->insertPointCloud(
      points, to_octomap(rays.origin_in_map), options_.max_range_m, kLazyEval, options_.discretize);
}

OccupancyTree OctomapVolume::Leaves() {
  LeafList list;
  for (auto leaf = tree_->begin_leafs(); leaf != tree_->end_leafs(); ++leaf) {
    const octomap::OcTreeKey key = leaf.getKey();
    const VoxelKey voxel = VoxelKey(key[0], key[1], key[2]).array() - (1 << (kOctreeDepth - 1));
    if (options_.region && !options_.region->Contains(voxel)) continue;
    list.Append({MortonCode(voxel), leaf->getLogOdds()});
  }
  return list.Tree(options_.resolution_m);
}

}  // namespace nightmap
