// SPDX-License-Identifier: Apache-2.0
// Writes octrees straight from their leaves in depth-first order: OctoMap's nodes, one allocation
// each, take several times the memory and the time.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>

#include "pipeline/base/files.h"
#include "pipeline/io/octree_leaves.h"

namespace nightmap {
namespace {

// `.ot`: of each node its log-odds, color and a bit for each child, then its children.
class ValueEncoder {
 public:
  using Rgb = std::array<std::uint8_t, 3>;
  struct Node {
    float log_odds = 0;
    Rgb mean{};  // of all that is below it
    Rgb rgb{};   // of the leaf that it is, or that was merged to it
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

  // As likely occupied as the likeliest child, and of their mean color. When eight leaves are
  // merged, OctoMap keeps a mean color only if the first of them has one.
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
  const std::string& Bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kNodeSize = 8;

  static constexpr Rgb kNoColor{255, 255, 255};

  // Of the children with a color.
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

// `.bt`: of each inner node two bits a child: none, free, occupied, inner; then its inner children.
class StateEncoder {
 public:
  enum class Node : unsigned { kFree = 1, kOccupied = 2, kInner = 3 };
  using Children = std::array<std::optional<Node>, 8>;

  Node Leaf(const PlacedLeaf& leaf) {
    ++num_nodes_;
    return leaf.log_odds >= 0 ? Node::kOccupied : Node::kFree;
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
      num_nodes_ -= 7;  // they become one
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
  const std::string& Bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t num_nodes_ = 0;
};

// The node of `height` that holds all of `leaves`.
template <typename Encoder>
typename Encoder::Node Encode(std::span<const PlacedLeaf> leaves, int height, Encoder& encoder) {
  if (leaves.front().height == height) return encoder.Leaf(leaves.front());
  const std::size_t begin = encoder.Open();
  const int shift = 3 * (height - 1);
  typename Encoder::Children children;
  while (!leaves.empty()) {
    const std::uint64_t child = leaves.front().code >> shift;
    const auto end = std::ranges::partition_point(
        leaves, [&](const PlacedLeaf& leaf) { return leaf.code >> shift == child; });
    const auto count = static_cast<std::size_t>(end - leaves.begin());
    children[child & 7] = Encode(leaves.first(count), height - 1, encoder);
    leaves = leaves.subspan(count);
  }
  return encoder.Close(begin, children);
}

template <typename Encoder>
void Write(const std::filesystem::path& path, const OccupancyTree& tree, std::string_view head) {
  const std::vector<PlacedLeaf> leaves = PlaceLeaves(tree, path.string());
  Encoder encoder;
  if (!leaves.empty()) Encode<Encoder>(leaves, kOctreeDepth, encoder);
  std::ostringstream stream;
  stream << head << "size " << encoder.NumNodes() << "\nres " << tree.resolution_m << "\ndata\n";
  WriteFile(path, stream.str() + encoder.Bytes());
}

}  // namespace

void WriteOctree(const std::filesystem::path& path, const OccupancyTree& tree) {
  Write<ValueEncoder>(path,
                      tree,
                      "# Octomap OcTree file\n"
                      "# (feel free to add / change comments, but leave the first line as it is!)\n"
                      "#\nid ColorOcTree\n");
}

void WriteBinaryOctree(const std::filesystem::path& path, const OccupancyTree& tree) {
  Write<StateEncoder>(path, tree, "# Octomap OcTree binary file\nid OcTree\n");
}

}  // namespace nightmap
