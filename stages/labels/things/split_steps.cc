// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/split_steps.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

#include "stages/labels/things/upright_box.h"

namespace nightmap {
namespace {

constexpr double kMinLength_m = 0.65;   // on both sides; a bed has a shorter head
constexpr double kMaxLength_m = 1;      // on both sides, of what is looked at
constexpr int kMinStep = 2;             // layers
constexpr double kMinLevelShare = 0.8;  // of slices beside the cut whose top is that of their part
constexpr double kMinFreeShare = 0.5;   // of the places above the lower part
constexpr std::size_t kMinTopVoxels = 1;  // of a slice in its top layer; one may be a stray

// The voxels of a cluster that are equally far along its longer side.
struct Slice {
  std::vector<std::size_t> voxels;
  int top = 0;  // the highest layer
};
using Slices = std::vector<Slice>;

Slices SlicesOf(const VoxelLabels& voxels, const Cluster& cluster) {
  std::vector<Eigen::Vector3d> points;
  for (const std::size_t i : cluster.voxels) {
    points.push_back(VoxelCentre(voxels.keys[i], voxels.resolution_m));
  }
  const UprightBox box = FitBox(points, voxels.resolution_m);
  const int axis = box.extent.sizes().x() >= box.extent.sizes().y() ? 0 : 1;
  const Rigid2 box_from_map = box.map_from_box.Inverse();
  std::map<int, Slice> by_place;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double along_m = (box_from_map * Eigen::Vector2d(points[p].head<2>()))[axis];
    Slice& slice = by_place[static_cast<int>(std::floor(along_m / voxels.resolution_m))];
    const int layer = voxels.keys[cluster.voxels[p]].z();
    slice.top = slice.voxels.empty() ? layer : std::max(slice.top, layer);
    slice.voxels.push_back(cluster.voxels[p]);
  }
  Slices slices;
  for (auto& [place, slice] : by_place) slices.push_back(std::move(slice));
  return slices;
}

struct Level {
  int layer = 0;
  std::ptrdiff_t num_slices = 0;  // whose top is this layer, or one beside it
};

// The level of slices [begin, end) when nearly all have it; nothing otherwise.
std::optional<Level> LevelOf(const Slices& slices, std::size_t begin, std::size_t end) {
  std::vector<int> tops;
  for (std::size_t i = begin; i < end; ++i) tops.push_back(slices[i].top);
  std::ranges::sort(tops);
  const int layer = tops[tops.size() / 2];
  const auto num_slices =
      std::ranges::count_if(tops, [&](int top) { return std::abs(top - layer) <= 1; });
  if (static_cast<double>(num_slices) < kMinLevelShare * static_cast<double>(end - begin))
    return {};
  return Level{layer, num_slices};
}

// Share of the places above slices [begin, end) that were seen free, two layers above their level.
double FreeShareAbove(const VoxelLabels& voxels,
                      const LabelledSpace& space,
                      const Slices& slices,
                      std::size_t begin,
                      std::size_t end,
                      int level) {
  double num_free = 0, num_all = 0;
  for (std::size_t i = begin; i < end; ++i) {
    for (const std::size_t voxel : slices[i].voxels) {
      VoxelKey above = voxels.keys[voxel];
      if (std::abs(above.z() - level) > 1) continue;
      above.z() = level + kMinStep;
      num_free += space.At(above) == VoxelState::kFree;
      ++num_all;
    }
  }
  return num_all > 0 ? num_free / num_all : 0;
}

// Where to cut, as the index of the first slice of the second part: where most slices have the
// level of their part.
std::optional<std::size_t> FindCut(const VoxelLabels& voxels,
                                   const LabelledSpace& space,
                                   const Slices& slices) {
  const auto min_slices = static_cast<std::size_t>(std::lround(kMinLength_m / voxels.resolution_m));
  const auto max_slices = static_cast<std::size_t>(std::lround(kMaxLength_m / voxels.resolution_m));
  std::optional<std::size_t> cut;
  std::ptrdiff_t most = 0;
  for (std::size_t i = min_slices; i + min_slices <= slices.size(); ++i) {
    const std::size_t begin = i - std::min(i, max_slices);
    const std::size_t end = std::min(slices.size(), i + max_slices);
    const auto before = LevelOf(slices, begin, i);
    const auto behind = LevelOf(slices, i, end);
    if (!before || !behind || std::abs(before->layer - behind->layer) < kMinStep) continue;
    if (before->num_slices + behind->num_slices <= most) continue;
    const double free_share = before->layer < behind->layer
                                  ? FreeShareAbove(voxels, space, slices, begin, i, before->layer)
                                  : FreeShareAbove(voxels, space, slices, i, end, behind->layer);
    if (free_share < kMinFreeShare) continue;
    most = before->num_slices + behind->num_slices;
    cut = i;
  }
  return cut;
}

}  // namespace

std::vector<Cluster> SplitSteps(const VoxelLabels& voxels,
                                const LabelledSpace& space,
                                const Cluster& cluster) {
  const Slices slices = SlicesOf(voxels, cluster);
  const auto cut = FindCut(voxels, space, slices);
  if (!cut) return {cluster};
  std::vector<Cluster> parts;
  const std::pair<std::size_t, std::size_t> ranges[] = {{0, *cut}, {*cut, slices.size()}};
  for (const auto& [begin, end] : ranges) {
    Cluster part{cluster.label, {}, cluster.mean_share};
    for (std::size_t i = begin; i < end; ++i) {
      part.voxels.insert(part.voxels.end(), slices[i].voxels.begin(), slices[i].voxels.end());
    }
    std::ranges::sort(part.voxels);
    for (Cluster& smaller : SplitSteps(voxels, space, part)) parts.push_back(std::move(smaller));
  }
  return parts;
}

}  // namespace nightmap
