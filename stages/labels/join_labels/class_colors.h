// SPDX-License-Identifier: Apache-2.0
// Colors of classes for the nodes of `.ot`.
#pragma once

#include <algorithm>
#include <map>
#include <vector>

#include "pipeline/dense/octree_encoders.h"
#include "pipeline/dense/voxel_labels_io.h"
#include "stages/labels/join_labels/palette.h"

namespace nightmap {

// An inner node has the color of the class that the votes of all voxels below it speak for most,
// and eight equal leaves become one only if they have one class. So no color is a mixture. Leaves
// must be of the smallest size where voxels have votes. Leaves without votes have no color.
class ClassColors {
 public:
  struct Color {
    Rgb rgb{};
    std::map<std::uint8_t, double> votes;  // by class
  };

  // Both must outlive it.
  ClassColors(const VoxelLabels& voxels, const std::vector<Rgb>& palette)
      : voxels_(&voxels), palette_(&palette) {}

  // Leaves come in Morton order, as the voxels are.
  Color Of(const PlacedLeaf& leaf) {
    while (next_ < voxels_->Size() && MortonCode(voxels_->keys[next_]) < leaf.code) ++next_;
    Color color{kNoColor, {}};
    if (next_ == voxels_->Size() || MortonCode(voxels_->keys[next_]) != leaf.code) return color;
    if (!leaf.Occupied()) return color;
    for (std::size_t v = voxels_->vote_offsets[next_]; v < voxels_->vote_offsets[next_ + 1]; ++v) {
      color.votes[voxels_->vote_labels[v]] = voxels_->vote_weights[v];
    }
    return WithRgb(std::move(color));
  }

  static bool MayMerge(const Color& a, const Color& b) { return a.rgb == b.rgb; }

  template <typename Children>
  Color Join(const Children& children, bool /*is_leaf*/) const {
    Color color;
    for (const auto& child : children) {
      if (!child) continue;
      for (const auto& [label, weight] : child->color.votes) color.votes[label] += weight;
    }
    return WithRgb(std::move(color));
  }

 private:
  Color WithRgb(Color color) const {
    const auto best = std::ranges::max_element(
        color.votes, [](const auto& a, const auto& b) { return a.second < b.second; });
    color.rgb = best == color.votes.end() ? kNoColor : (*palette_)[best->first];
    return color;
  }

  const VoxelLabels* voxels_;
  const std::vector<Rgb>* palette_;
  std::size_t next_ = 0;  // voxel that the next leaf may be
};

}  // namespace nightmap
