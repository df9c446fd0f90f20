// SPDX-License-Identifier: Apache-2.0
#include "stages/octree/scan.h"

#include <algorithm>
#include <limits>

#include "stages/octree/voxel_walk.h"

namespace nightmap {
namespace {

// Points that share a ray.
struct RayEnd {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double margin_m = 0;
};

class ScanTracer {
 public:
  ScanTracer(const Scan& scan, const ScanOptions& options)
      : scan_(scan),
        options_(options),
        origin_voxel_(VoxelOf(scan.origin_in_map, options.resolution_m)) {}

  ScanEvidence Trace() {
    MarkHits();
    SumHits();
    CastRays();
    Finish();
    return std::move(evidence_);
  }

 private:
  static constexpr std::uint32_t kBeyondRange = std::numeric_limits<std::uint32_t>::max();

  void MarkHits() {
    hit_of_point_.reserve(scan_.points.size());
    const double max_range_m2 = options_.max_range_m * options_.max_range_m;
    for (const ScanPoint& point : scan_.points) {
      if ((point.point_in_map - scan_.origin_in_map).squaredNorm() > max_range_m2) {
        hit_of_point_.push_back(kBeyondRange);
        continue;
      }
      const auto voxel = MortonCode(VoxelOf(point.point_in_map, options_.resolution_m));
      const std::size_t entry = EntryOf(BlockOf(voxel));
      blocks_.Entries()[entry].value.hit.Set(IndexInBlock(voxel));
      hit_of_point_.push_back(
          static_cast<std::uint32_t>(entry << kBlockShift | IndexInBlock(voxel)));
    }
  }

  // Numbers the hits by block and by order in it, then sums what lies in each.
  void SumHits() {
    std::size_t num_hits = 0;
    for (auto& [block, evidence] : blocks_.Entries()) {
      evidence.first_color = static_cast<std::uint32_t>(num_hits);
      num_hits += evidence.hit.Count();
    }
    evidence_.colors.resize(num_hits);
    ends_.resize(options_.discretize ? num_hits : 0);
    for (std::size_t i = 0; i < scan_.points.size(); ++i) {
      if (hit_of_point_[i] == kBeyondRange) continue;
      const ScanPoint& point = scan_.points[i];
      const BlockEvidence& block = blocks_.Entries()[BlockOf(hit_of_point_[i])].value;
      const std::size_t hit = block.first_color + block.hit.Rank(IndexInBlock(hit_of_point_[i]));
      evidence_.colors[hit].Add({{point.rgb[0], point.rgb[1], point.rgb[2]}, 1});
      if (!options_.discretize) continue;
      ends_[hit].sum += point.point_in_map;
      ends_[hit].margin_m = std::max(ends_[hit].margin_m, point.margin_m);
    }
  }

  void CastRays() {
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      CastRay(ends_[i].sum / evidence_.colors[i].count, ends_[i].margin_m);
    }
    for (std::size_t i = 0; i < scan_.points.size(); ++i) {
      const ScanPoint& point = scan_.points[i];
      if (hit_of_point_[i] == kBeyondRange) {
        CastRayBeyond(point.point_in_map);
      } else if (!options_.discretize) {
        CastRay(point.point_in_map, point.margin_m);
      }
    }
  }

  void CastRayBeyond(const Eigen::Vector3d& point) {
    const Eigen::Vector3d offset = point - scan_.origin_in_map;
    const Eigen::Vector3d end =
        scan_.origin_in_map + offset * (options_.max_range_m / offset.norm());
    if (options_.discretize) {
      const std::uint64_t voxel = MortonCode(VoxelOf(end, options_.resolution_m));
      if (!ended_beyond_.At(BlockOf(voxel)).Insert(IndexInBlock(voxel))) return;
    }
    CastRay(end, 0);
  }

  // Backwards, from margin_m before `end`.
  void CastRay(const Eigen::Vector3d& end, double margin_m) {
    ++evidence_.num_rays;
    Eigen::Vector3d start = end;
    if (margin_m > 0) {
      const Eigen::Vector3d to_origin = scan_.origin_in_map - end;
      const double length_m = to_origin.norm();
      if (margin_m >= length_m) return;
      start += to_origin * (margin_m / length_m);
    }
    const VoxelKey start_voxel = VoxelOf(start, options_.resolution_m);
    const VoxelWalk walk(start / options_.resolution_m,
                         (scan_.origin_in_map - start) / options_.resolution_m);
    BlockBits* passed = nullptr;
    std::uint64_t block = kNoBlock;
    walk.Visit((origin_voxel_ - start_voxel).cwiseAbs().sum(), [&](std::uint64_t voxel) {
      if (BlockOf(voxel) != block) {
        block = BlockOf(voxel);
        passed = &blocks_.Entries()[EntryOf(block)].value.passed;
      }
      passed->Set(IndexInBlock(voxel));
    });
  }

  std::size_t EntryOf(std::uint64_t block) {
    if (block != last_block_) {
      last_block_ = block;
      last_entry_ = blocks_.IndexOf(block);
    }
    return last_entry_;
  }

  void Finish() {
    for (auto& entry : blocks_.Entries()) {
      for (std::size_t w = 0; w < kBlockWords; ++w) {
        entry.value.passed.words[w] &= ~entry.value.hit.words[w];
      }
      if (options_.region) Crop(entry);
    }
    evidence_.blocks = std::move(blocks_.Entries());
    std::erase_if(evidence_.blocks, [](const auto& entry) {
      return entry.value.hit.None() && entry.value.passed.None();
    });
    std::ranges::sort(evidence_.blocks, {}, [](const auto& entry) { return entry.block; });
  }

  void Crop(BlockMap<BlockEvidence>::Entry& entry) {
    const auto voxel = [&](std::size_t i) {
      return KeyOfMortonCode(entry.block << kBlockShift | i);
    };
    const VoxelBox& region = *options_.region;
    if (region.Contains(voxel(0)) && region.Contains(voxel(kBlockVoxels - 1))) return;
    BlockBits inside;
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      if (region.Contains(voxel(i))) inside.Set(i);
    }
    const BlockBits hit = entry.value.hit;
    std::size_t color = entry.value.first_color;
    entry.value.first_color = static_cast<std::uint32_t>(evidence_.colors.size());
    hit.ForEach([&](std::size_t i) {
      const ColorSum sum = evidence_.colors[color++];
      if (inside.Test(i)) evidence_.colors.push_back(sum);
    });
    entry.value.hit &= inside;
    entry.value.passed &= inside;
  }

  static constexpr std::uint64_t kNoBlock = ~std::uint64_t{0};

  const Scan& scan_;
  const ScanOptions& options_;
  VoxelKey origin_voxel_;
  BlockMap<BlockEvidence> blocks_;
  BlockMap<BlockBits> ended_beyond_;  // voxels with the end of a ray that was cut
  std::uint64_t last_block_ = kNoBlock;
  std::size_t last_entry_ = 0;
  std::vector<std::uint32_t> hit_of_point_;  // its block's entry and its index in the block
  std::vector<RayEnd> ends_;                 // of each hit
  ScanEvidence evidence_;
};

}  // namespace

ScanEvidence TraceScan(const Scan& scan, const ScanOptions& options) {
  return ScanTracer(scan, options).Trace();
}

}  // namespace nightmap
