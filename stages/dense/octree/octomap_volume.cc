// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/octomap_volume.h"

#include <octomap/OcTree.h>

#include "pipeline/dense/octree_leaves.h"
#include "stages/dense/octree/voxel_block.h"

namespace nightmap {
namespace {

VoxelKey VoxelOfKey(const octomap::OcTreeKey& key) {
  return VoxelKey(key[0], key[1], key[2]).array() - (1 << (kOctreeDepth - 1));
}

}  // namespace

class OctomapVolume::Tree : public octomap::OcTree {
 public:
  Tree(const SensorModel& model, double resolution_m)
      : OcTree(resolution_m),
        min_keyframes_(model.min_keyframes),
        counts_(model.threshold < 0 || model.min_keyframes > 1) {
    prob_hit_log = model.hit;
    prob_miss_log = model.miss;
    clamping_thres_min = model.min;
    clamping_thres_max = model.max;
  }

  using OcTree::updateNode;
  // insertPointCloud calls it once for each voxel that a keyframe hits.
  octomap::OcTreeNode* updateNode(const octomap::OcTreeKey& key,
                                  bool occupied,
                                  bool lazy_eval) override {
    if (occupied && counts_) ++num_hits_.At(MortonCode(VoxelOfKey(key)));
    return OcTree::updateNode(key, occupied, lazy_eval);
  }

  // A voxel whose log-odds reach the threshold is occupied only if this is true.
  bool EnoughKeyframesHit(const VoxelKey& voxel) const {
    if (!counts_) return true;
    const int* num_hits = num_hits_.Find(MortonCode(voxel));
    return num_hits != nullptr && *num_hits >= min_keyframes_;
  }

 private:
  int min_keyframes_;
  bool counts_;             // else no voxel reaches the threshold without the hit that is enough
  BlockMap<int> num_hits_;  // by voxel
};

OctomapVolume::OctomapVolume(const SensorModel& model, const TraceOptions& options)
    : threshold_(model.threshold),
      options_(options),
      tree_(std::make_unique<Tree>(model, options.resolution_m)) {}

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
    const VoxelKey voxel = VoxelOfKey(leaf.getKey());
    if (options_.region && !options_.region->Contains(voxel)) continue;
    const PlacedLeaf placed{MortonCode(voxel), leaf->getLogOdds() - threshold_};
    if (placed.Occupied() && !tree_->EnoughKeyframesHit(voxel)) continue;
    list.Append(placed);
  }
  return list.Tree(options_.resolution_m);
}

}  // namespace nightmap
