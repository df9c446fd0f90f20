// SPDX-License-Identifier: Apache-2.0
#include "stages/octree/scan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace nightmap {
namespace {

struct Ray {
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  double margin_m = 0;
};

// Points that share a ray, summed.
struct RayGroup {
  Eigen::Vector3d end_sum = Eigen::Vector3d::Zero();
  double margin_m = 0;
  int count = 0;
};

class ScanTracer {
 public:
  ScanTracer(const Eigen::Vector3d& origin, const ScanOptions& options, const VoxelSupport* support)
      : origin_(origin), options_(options), support_(support) {}

  void Add(const ScanPoint& point) {
    const Eigen::Vector3d offset = point.point_in_map - origin_;
    const double range_m = offset.norm();
    if (range_m > options_.max_range_m) {
      AddRay({origin_ + offset * (options_.max_range_m / range_m), 0});
      return;
    }
    const VoxelKey voxel = VoxelOf(point.point_in_map, options_.resolution_m);
    if (!Supported(voxel)) {
      ++evidence_.num_unsupported;
      return;
    }
    evidence_.blocks.At(BlockOf(voxel)).hit.set(IndexInBlock(voxel));
    AddColor(voxel, point.rgb);
    AddRay({point.point_in_map, point.margin_m});
  }

  ScanEvidence Finish() {
    for (const RayGroup& group : groups_) {
      Trace({group.end_sum / group.count, group.margin_m});
    }
    evidence_.num_rays = groups_.size();
    return std::move(evidence_);
  }

 private:
  bool Supported(const VoxelKey& voxel) const {
    if (support_ == nullptr) return true;
    const BlockBits* block = support_->Find(BlockOf(voxel));
    return block != nullptr && block->test(IndexInBlock(voxel));
  }

  void AddColor(const VoxelKey& voxel, const std::array<std::uint8_t, 3>& rgb) {
    const auto [entry, is_new] =
        color_index_.try_emplace(PackVoxel(voxel), evidence_.colors.size());
    if (is_new) evidence_.colors.push_back({voxel, {}});
    ColorSum& color = evidence_.colors[entry->second].color;
    for (std::size_t channel = 0; channel < 3; ++channel) color.rgb[channel] += rgb[channel];
    ++color.count;
  }

  void AddRay(const Ray& ray) {
    std::size_t index = groups_.size();
    if (options_.discretize) {
      const VoxelKey voxel = VoxelOf(ray.end, options_.resolution_m);
      index = group_index_.try_emplace(PackVoxel(voxel), index).first->second;
    }
    if (index == groups_.size()) groups_.emplace_back();
    RayGroup& group = groups_[index];
    group.end_sum += ray.end;
    group.margin_m = std::max(group.margin_m, ray.margin_m);
    ++group.count;
  }

  // Marks the voxels from the origin to the ray's end less its margin.
  void Trace(const Ray& ray) {
    const Eigen::Vector3d full = ray.end - origin_;
    const double length_m = full.norm() - ray.margin_m;
    if (!(length_m > 0)) return;
    const Eigen::Vector3d start = origin_ / options_.resolution_m;
    const Eigen::Vector3d step = full.normalized() * (length_m / options_.resolution_m);
    VoxelKey voxel = start.array().floor().matrix().cast<int>();
    Eigen::Vector3d next;   // share of the ray at which the voxel is left along each axis
    Eigen::Vector3d delta;  // share of the ray per voxel along each axis
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kNever = std::numeric_limits<double>::infinity();
      const double edge = voxel[axis] + (step[axis] > 0 ? 1 : 0);
      delta[axis] = step[axis] != 0 ? 1 / std::abs(step[axis]) : kNever;
      next[axis] = step[axis] != 0 ? (edge - start[axis]) / step[axis] : kNever;
    }
    const VoxelKey direction = (step.array() > 0).select(VoxelKey::Ones(), -VoxelKey::Ones());
    for (double share = 0; share < 1;) {
      BlockEvidence& block = evidence_.blocks.At(BlockOf(voxel));
      const std::size_t index = IndexInBlock(voxel);
      if (!block.hit.test(index)) block.passed.set(index);
      int axis = 0;
      share = next.minCoeff(&axis);
      next[axis] += delta[axis];
      voxel[axis] += direction[axis];
    }
  }

  Eigen::Vector3d origin_;
  const ScanOptions& options_;
  const VoxelSupport* support_;
  ScanEvidence evidence_;
  std::vector<RayGroup> groups_;  // by first point, so that the order of the pixels decides
  std::unordered_map<std::uint64_t, std::size_t> group_index_;
  std::unordered_map<std::uint64_t, std::size_t> color_index_;
};

}  // namespace

ScanEvidence TraceScan(const Eigen::Vector3d& origin,
                       const std::vector<ScanPoint>& points,
                       const ScanOptions& options,
                       const VoxelSupport* support) {
  ScanTracer tracer(origin, options, support);
  for (const ScanPoint& point : points) tracer.Add(point);
  return tracer.Finish();
}

}  // namespace nightmap
