// SPDX-License-Identifier: Apache-2.0
// OctoMap's node formats. An encoder receives the nodes depth first: Leaf; or Open, the node's
// children, and Close with the results of these calls. It keeps the bytes of the file after the
// header.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "pipeline/dense/octree_leaves.h"

namespace nightmap {

// Colors of `.ot`: an inner node has the mean color of its leaves.
class MeanColors {
 public:
  struct Color {
    Rgb mean{};  // of all nodes below
    Rgb rgb{};   // of the leaf, or of the leaves merged into it
  };

  Color Of(const PlacedLeaf& leaf) { return {leaf.rgb, leaf.rgb}; }
  static bool MayMerge(const Color&, const Color&) { return true; }

  // When eight leaves are merged, OctoMap keeps a mean color only if the first of them has a color.
  template <typename Children>
  Color Join(const Children& children, bool is_leaf) const {
    const Rgb mean = MeanOf(children, &Color::mean);
    if (!is_leaf) return {mean, mean};
    return {mean, children[0]->color.rgb == kNoColor ? kNoColor : MeanOf(children, &Color::rgb)};
  }

 private:
  // Mean over the children that have a color.
  template <typename Children>
  static Rgb MeanOf(const Children& children, Rgb Color::*color) {
    std::array<int, 3> sum{};
    int count = 0;
    for (const auto& child : children) {
      if (!child || child->color.*color == kNoColor) continue;
      for (std::size_t i = 0; i < 3; ++i) sum[i] += (child->color.*color)[i];
      ++count;
    }
    if (count == 0) return kNoColor;
    Rgb mean{};
    for (std::size_t i = 0; i < 3; ++i) mean[i] = static_cast<std::uint8_t>(sum[i] / count);
    return mean;
  }
};

// `.ot`: for each node its log-odds, color and one bit per child, then its children. `Colors` gives
// the color of a leaf and of a node, and says which equal leaves may become one.
template <typename Colors>
class NodeEncoder {
 public:
  static constexpr std::string_view kHead =
      "# Octomap OcTree file\n"
      "# (feel free to add / change comments, but leave the first line as it is!)\n"
      "#\n";
  static constexpr std::string_view kType = "id ColorOcTree\n";

  struct Node {
    float log_odds = 0;
    bool is_leaf = true;
    typename Colors::Color color;
  };
  using Children = std::array<std::optional<Node>, 8>;

  explicit NodeEncoder(Colors colors = {}) : colors_(colors) {}

  Node Leaf(const PlacedLeaf& leaf) {
    Node node{leaf.log_odds, true, colors_.Of(leaf)};
    Put(Open(), node, 0);
    return node;
  }

  std::size_t Open() {
    const std::size_t begin = bytes_.size();
    bytes_.resize(begin + kNodeSize);
    return begin;
  }

  // The log-odds of the likeliest child.
  Node Close(std::size_t begin, const Children& children) {
    unsigned mask = 0;
    Node node{-std::numeric_limits<float>::infinity(), false, {}};
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (!children[i]) continue;
      mask |= 1U << i;
      node.log_odds = std::max(node.log_odds, children[i]->log_odds);
    }
    node.is_leaf = std::ranges::all_of(children, [&](const auto& child) {
      return child && child->is_leaf && child->log_odds == node.log_odds &&
             Colors::MayMerge(child->color, children[0]->color);
    });
    node.color = colors_.Join(children, node.is_leaf);
    if (node.is_leaf) bytes_.resize(begin + kNodeSize);
    Put(begin, node, node.is_leaf ? 0 : mask);
    return node;
  }

  std::size_t NumNodes() const { return bytes_.size() / kNodeSize; }
  void Reserve(std::size_t num_bytes) { bytes_.reserve(num_bytes); }
  std::string TakeBytes() { return std::move(bytes_); }

 private:
  static constexpr std::size_t kNodeSize = 8;

  void Put(std::size_t begin, const Node& node, unsigned mask) {
    std::memcpy(&bytes_[begin], &node.log_odds, sizeof(node.log_odds));
    std::memcpy(&bytes_[begin + 4], node.color.rgb.data(), node.color.rgb.size());
    bytes_[begin + 7] = static_cast<char>(mask);
  }

  Colors colors_;
  std::string bytes_;
};

using ValueEncoder = NodeEncoder<MeanColors>;

// `.bt`: for each inner node two bits per child (none, free, occupied, inner), then its inner
// children.
class StateEncoder {
 public:
  static constexpr std::string_view kHead = "# Octomap OcTree binary file\n";
  static constexpr std::string_view kType = "id OcTree\n";

  enum class Node : unsigned { kFree = 1, kOccupied = 2, kInner = 3 };
  using Children = std::array<std::optional<Node>, 8>;

  Node Leaf(const PlacedLeaf& leaf) {
    ++num_nodes_;
    return leaf.Occupied() ? Node::kOccupied : Node::kFree;
  }

  std::size_t Open() {
    const std::size_t begin = bytes_.size();
    bytes_.resize(begin + 2);
    return begin;
  }

  Node Close(std::size_t begin, const Children& children) {
    const bool is_leaf =
        children[0] != Node::kInner && std::ranges::all_of(children, [&](const auto& child) {
          return child && child == children[0];
        });
    if (is_leaf) {
      bytes_.resize(begin);
      num_nodes_ -= 7;  // eight become one
      return *children[0];
    }
    ++num_nodes_;
    unsigned bits = 0;
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (children[i]) bits |= static_cast<unsigned>(*children[i]) << 2 * i;
    }
    bytes_[begin] = static_cast<char>(bits & 0xFF);
    bytes_[begin + 1] = static_cast<char>(bits >> 8);
    return Node::kInner;
  }

  std::size_t NumNodes() const { return num_nodes_; }
  std::string TakeBytes() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t num_nodes_ = 0;
};

}  // namespace nightmap
