// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/trace_rays.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "stages/dense/octree/voxel_walk.h"

namespace nightmap {
namespace {

// A voxel with points, and the sums over them.
struct Hit {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double margin_m = 0;
  ColorSum color;

  void Add(const RayEnd& point) {
    sum += point.point_in_map;
    margin_m = std::max(margin_m, point.margin_m);
    color.Add({{point.rgb[0], point.rgb[1], point.rgb[2]}, 1});
  }
};

// A cube of 8 x 8 x 8 blocks, large enough for a ray to stay in it for a while.
struct RegionBits {
  std::array<BlockBits, kBlockVoxels> hit;
  std::array<BlockBits, kBlockVoxels> passed;
};

class KeyframeTracer {
 public:
  KeyframeTracer(const KeyframeRays& rays, const TraceOptions& options)
      : rays_(rays),
        options_(options),
        origin_voxel_(VoxelOf(rays.origin_in_map, options.resolution_m)) {}

  KeyframeEvidence Trace() {
    AddPoints();
    for (const auto& [voxel, hit] : hits_.Entries()) {
      const std::uint64_t block = BlockOf(voxel);
      RegionAt(BlockOf(block)).hit[IndexInBlock(block)].Set(IndexInBlock(voxel));
      if (options_.discretize) CastRay(hit.sum / hit.color.count, hit.margin_m);
    }
    walks_.Finish([this](int lane, std::uint64_t voxel) { Pass(lane, voxel); });
    Finish();
    return std::move(evidence_);
  }

 private:
  // Neighbouring pixels mostly end in one voxel, so it is looked up once for all of them.
  void AddPoints() {
    const double max_range_m2 = options_.max_range_m * options_.max_range_m;
    VoxelKey last = VoxelKey::Constant(std::numeric_limits<int>::max());
    Hit* hit = nullptr;
    for (const RayEnd& point : rays_.points) {
      if ((point.point_in_map - rays_.origin_in_map).squaredNorm() > max_range_m2) {
        CastRayBeyond(point.point_in_map);
        continue;
      }
      const VoxelKey voxel = VoxelOf(point.point_in_map, options_.resolution_m);
      if (voxel != last) {
        last = voxel;
        hit = &hits_.At(MortonCode(voxel));
      }
      hit->Add(point);
      if (!options_.discretize) CastRay(point.point_in_map, point.margin_m);
    }
  }

  void CastRayBeyond(const Eigen::Vector3d& point) {
    const Eigen::Vector3d offset = point - rays_.origin_in_map;
    const Eigen::Vector3d end =
        rays_.origin_in_map + offset * (options_.max_range_m / offset.norm());
    if (options_.discretize) {
      const std::uint64_t voxel = MortonCode(VoxelOf(end, options_.resolution_m));
      if (!ended_beyond_.At(BlockOf(voxel)).Insert(IndexInBlock(voxel))) return;
    }
    CastRay(end, 0);
  }

  // Casts backwards, from margin_m before `end`.
  void CastRay(const Eigen::Vector3d& end, double margin_m) {
    ++evidence_.num_rays;
    Eigen::Vector3d start = end;
    if (margin_m > 0) {
      const Eigen::Vector3d to_origin = rays_.origin_in_map - end;
      const double length_m = to_origin.norm();
      if (margin_m >= length_m) return;
      start += to_origin * (margin_m / length_m);
    }
    const VoxelKey start_voxel = VoxelOf(start, options_.resolution_m);
    const VoxelWalk walk(start / options_.resolution_m,
                         (rays_.origin_in_map - start) / options_.resolution_m);
    walks_.Add(walk,
               (origin_voxel_ - start_voxel).cwiseAbs().sum(),
               [this](int lane, std::uint64_t voxel) { Pass(lane, voxel); });
  }

  void Pass(int lane, std::uint64_t voxel) {
    const std::uint64_t block = BlockOf(voxel);
    Place& place = places_[static_cast<std::size_t>(lane)];
    if (BlockOf(block) != place.region) {
      place = {BlockOf(block), RegionAt(BlockOf(block)).passed.data()};
    }
    place.passed[IndexInBlock(block)].Set(IndexInBlock(voxel));
  }

  RegionBits& RegionAt(std::uint64_t code) {
    std::unique_ptr<RegionBits>& region = regions_.At(code);
    if (!region) region = std::make_unique<RegionBits>();
    return *region;
  }

  void Finish() {
    std::ranges::sort(regions_.Entries(), {}, [](const auto& entry) { return entry.block; });
    for (const auto& [code, region] : regions_.Entries()) {
      for (std::size_t i = 0; i < kBlockVoxels; ++i) {
        AddBlock(code << kBlockShift | i, region->hit[i], region->passed[i]);
      }
    }
  }

  void AddBlock(std::uint64_t block, BlockBits hit, BlockBits passed) {
    if (hit.None() && passed.None()) return;
    if (options_.region) Crop(block, hit, passed);
    if (hit.None() && passed.None()) return;
    for (std::size_t w = 0; w < kBlockWords; ++w) passed.words[w] &= ~hit.words[w];
    const auto first_color = static_cast<std::uint32_t>(evidence_.colors.size());
    evidence_.blocks.push_back({block, {hit, passed, first_color}});
    hit.ForEach([&](std::size_t i) {
      evidence_.colors.push_back(hits_.At(block << kBlockShift | i).color);
    });
  }

  void Crop(std::uint64_t block, BlockBits& hit, BlockBits& passed) const {
    const auto inside = [&](std::size_t i) {
      return options_.region->Contains(KeyOfMortonCode(block << kBlockShift | i));
    };
    if (inside(0) && inside(kBlockVoxels - 1)) return;
    BlockBits bits;
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      if (inside(i)) bits.Set(i);
    }
    hit &= bits;
    passed &= bits;
  }

  static constexpr std::uint64_t kNowhere = ~std::uint64_t{0};

  // Current position of one of the two walks.
  struct Place {
    std::uint64_t region = kNowhere;
    BlockBits* passed = nullptr;
  };

  const KeyframeRays& rays_;
  const TraceOptions& options_;
  VoxelKey origin_voxel_;
  BlockMap<Hit> hits_;  // by voxel
  BlockMap<std::unique_ptr<RegionBits>> regions_;
  VoxelWalkPair walks_;
  std::array<Place, 2> places_;
  BlockMap<BlockBits> ended_beyond_;  // voxels in which a cut ray ended
  KeyframeEvidence evidence_;
};

}  // namespace

KeyframeEvidence TraceRays(const KeyframeRays& rays, const TraceOptions& options) {
  return KeyframeTracer(rays, options).Trace();
}

}  // namespace nightmap
