// SPDX-License-Identifier: Apache-2.0
// `.ot` whose colors are those of classes, for OctreeWriter.
#pragma once

#include <map>

#include "pipeline/dense/octree_encoders.h"
#include "pipeline/dense/voxel_labels_io.h"
#include "stages/labels/join_labels/palette.h"

namespace nightmap {

// Nodes as ValueEncoder writes them, but for their colors: an inner node has the color of the class
// that the votes of all voxels below it speak for most, and eight equal leaves become one only if
// they have one class. So no color is a mixture. Leaves must be of the smallest size where voxels
// have votes. Leaves without votes have no color.
class LabelEncoder {
 public:
  static constexpr std::string_view kHead = ValueEncoder::kHead;
  static constexpr std::string_view kType = ValueEncoder::kType;

  struct Node {
    float log_odds = 0;
    Rgb rgb{};
    std::map<std::uint8_t, double> votes;  // by class
    bool is_leaf = true;
  };
  using Children = std::array<std::optional<Node>, 8>;

  // Both must outlive it.
  void Use(const VoxelLabels& voxels, const std::vector<Rgb>& palette) {
    voxels_ = &voxels;
    palette_ = &palette;
  }

  Node Leaf(const PlacedLeaf& leaf) {
    Node node{leaf.log_odds, kNoColor, VotesOf(leaf), true};
    node.rgb = ColorOf(node.votes);
    Put(Open(), node, 0);
    return node;
  }

  std::size_t Open() {
    const std::size_t begin = bytes_.size();
    bytes_.resize(begin + kNodeSize);
    return begin;
  }

  Node Close(std::size_t begin, const Children& children) {
    unsigned mask = 0;
    Node node{-std::numeric_limits<float>::infinity(), kNoColor, {}, false};
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (!children[i]) continue;
      mask |= 1U << i;
      node.log_odds = std::max(node.log_odds, children[i]->log_odds);
      for (const auto& [label, weight] : children[i]->votes) node.votes[label] += weight;
    }
    node.rgb = ColorOf(node.votes);
    node.is_leaf = std::ranges::all_of(children, [&](const auto& child) {
      return child && child->is_leaf && child->log_odds == node.log_odds &&
             child->rgb == children[0]->rgb;
    });
    if (node.is_leaf) {
      bytes_.resize(begin + kNodeSize);
      mask = 0;
    }
    Put(begin, node, mask);
    return node;
  }

  std::size_t NumNodes() const { return bytes_.size() / kNodeSize; }
  std::string TakeBytes() { return std::move(bytes_); }

 private:
  static constexpr std::size_t kNodeSize = 8;
  static constexpr Rgb kNoColor{255, 255, 255};

  // Leaves come in Morton order, as the voxels are.
  std::map<std::uint8_t, double> VotesOf(const PlacedLeaf& leaf) {
    while (next_ < voxels_->Size() && MortonCode(voxels_->keys[next_]) < leaf.code) ++next_;
    std::map<std::uint8_t, double> votes;
    if (next_ == voxels_->Size() || MortonCode(voxels_->keys[next_]) != leaf.code) return votes;
    if (!leaf.Occupied()) return votes;
    for (std::size_t v = voxels_->vote_offsets[next_]; v < voxels_->vote_offsets[next_ + 1]; ++v) {
      votes[voxels_->vote_labels[v]] = voxels_->vote_weights[v];
    }
    return votes;
  }

  Rgb ColorOf(const std::map<std::uint8_t, double>& votes) const {
    const auto best = std::ranges::max_element(
        votes, [](const auto& a, const auto& b) { return a.second < b.second; });
    return best == votes.end() ? kNoColor : (*palette_)[best->first];
  }

  void Put(std::size_t begin, const Node& node, unsigned mask) {
    std::memcpy(&bytes_[begin], &node.log_odds, sizeof(node.log_odds));
    std::memcpy(&bytes_[begin + 4], node.rgb.data(), node.rgb.size());
    bytes_[begin + 7] = static_cast<char>(mask);
  }

  const VoxelLabels* voxels_ = nullptr;
  const std::vector<Rgb>* palette_ = nullptr;
  std::size_t next_ = 0;  // voxel that the next leaf may be
  std::string bytes_;
};

}  // namespace nightmap
