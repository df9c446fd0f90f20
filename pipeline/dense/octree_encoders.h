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

// `.ot`: for each node its log-odds, color and one bit per child, then its children.
class ValueEncoder {
 public:
  static constexpr std::string_view kHead =
      "# Octomap OcTree file\n"
      "# (feel free to add / change comments, but leave the first line as it is!)\n"
      "#\n";
  static constexpr std::string_view kType = "id ColorOcTree\n";

  using Rgb = std::array<std::uint8_t, 3>;
  struct Node {
    float log_odds = 0;
    Rgb mean{};  // of all nodes below
    Rgb rgb{};   // of the leaf, or of the leaves merged into it
    bool is_leaf = true;
  };
  using Children = std::array<std::optional<Node>, 8>;

  Node Leaf(const PlacedLeaf& leaf) {
    Put(Open(), leaf.log_odds, leaf.rgb, 0);
    return {leaf.log_odds, leaf.rgb, leaf.rgb, true};
  }

  std::size_t Open() {
    const std::size_t begin = bytes_.size();
    bytes_.resize(begin + kNodeSize);
    return begin;
  }

  // The log-odds of the likeliest child and the children's mean color. When eight leaves are
  // merged, OctoMap keeps a mean color only if the first of them has a color.
  Node Close(std::size_t begin, const Children& children) {
    unsigned mask = 0;
    float log_odds = -std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (!children[i]) continue;
      mask |= 1U << i;
      log_odds = std::max(log_odds, children[i]->log_odds);
    }
    const Rgb mean = MeanColor(children, &Node::mean);
    const bool is_leaf = std::ranges::all_of(children, [&](const auto& child) {
      return child && child->is_leaf && child->log_odds == log_odds;
    });
    if (!is_leaf) {
      Put(begin, log_odds, mean, mask);
      return {log_odds, mean, mean, false};
    }
    const Rgb rgb = children[0]->rgb == kNoColor ? kNoColor : MeanColor(children, &Node::rgb);
    bytes_.resize(begin + kNodeSize);
    Put(begin, log_odds, rgb, 0);
    return {log_odds, mean, rgb, true};
  }

  std::size_t NumNodes() const { return bytes_.size() / kNodeSize; }
  void Reserve(std::size_t num_bytes) { bytes_.reserve(num_bytes); }
  std::string TakeBytes() { return std::move(bytes_); }

 private:
  static constexpr std::size_t kNodeSize = 8;

  static constexpr Rgb kNoColor{255, 255, 255};

  // Mean over the children that have a color.
  static Rgb MeanColor(const Children& children, Rgb Node::*color) {
    std::array<int, 3> sum{};
    int count = 0;
    for (const auto& child : children) {
      if (!child || (*child).*color == kNoColor) continue;
      for (std::size_t i = 0; i < 3; ++i) sum[i] += ((*child).*color)[i];
      ++count;
    }
    if (count == 0) return kNoColor;
    Rgb mean{};
    for (std::size_t i = 0; i < 3; ++i) mean[i] = static_cast<std::uint8_t>(sum[i] / count);
    return mean;
  }

  void Put(std::size_t begin, float log_odds, const Rgb& rgb, unsigned mask) {
    std::memcpy(&bytes_[begin], &log_odds, sizeof(log_odds));
    std::memcpy(&bytes_[begin + 4], rgb.data(), rgb.size());
    bytes_[begin + 7] = static_cast<char>(mask);
  }

  std::string bytes_;
};

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
