// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/vocabulary_tree.h"

#include <queue>
#include <stdexcept>

#include "pipeline/base/parallel.h"
#include "pipeline/camera/descriptor_distance.h"

namespace nightmap {
namespace {

void Demand(bool condition, const char* message) {
  if (!condition) throw std::invalid_argument(message);
}

// In breadth-first order the children of the inner nodes follow each other without gap or overlap,
// so a running count checks "exactly one parent".
void CheckNodes(const std::vector<VocabularyTree::Node>& nodes, int depth) {
  Demand(!nodes.empty() && nodes[0].level == 0, "nodes: no root");
  std::size_t next_child = 1;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto& node = nodes[i];
    Demand(node.level >= 0 && node.level <= depth, "nodes: level out of range");
    Demand(node.num_children >= 0, "nodes: negative number of children");
    Demand((node.first_child == 0) == (node.num_children == 0), "nodes: leaf with children");
    if (node.num_children == 0) continue;
    const auto num_children = static_cast<std::size_t>(node.num_children);
    Demand(next_child > i && node.first_child == static_cast<int>(next_child) &&
               num_children <= nodes.size() - next_child,
           "nodes: index of first child out of order");
    for (std::size_t child = next_child; child < next_child + num_children; ++child) {
      Demand(nodes[child].level == node.level + 1, "nodes: level of a child");
    }
    next_child += num_children;
  }
  Demand(next_child == nodes.size(), "nodes: node without parent");
}

}  // namespace

VocabularyTree::VocabularyTree(DescriptorKind kind,
                               int depth,
                               std::vector<Node> nodes,
                               std::vector<std::uint8_t> centres)
    : kind_(kind), depth_(depth), nodes_(std::move(nodes)), centres_(std::move(centres)) {
  CheckNodes(nodes_, depth_);
  Demand(centres_.size() == nodes_.size() * static_cast<std::size_t>(DescriptorSize(kind_)),
         "centres: not one descriptor a node");
}

int VocabularyTree::NumNodes() const { return static_cast<int>(nodes_.size()); }
int VocabularyTree::Depth() const { return depth_; }
DescriptorKind VocabularyTree::Kind() const { return kind_; }

int VocabularyTree::NearestChild(const Node& node, const std::uint8_t* descriptor) const {
  const auto size = static_cast<std::size_t>(DescriptorSize(kind_));
  int best_child = node.first_child;
  int best_distance = -1;
  for (int child = node.first_child; child < node.first_child + node.num_children; ++child) {
    const int distance =
        DescriptorDistance(kind_, descriptor, &centres_[static_cast<std::size_t>(child) * size]);
    if (best_distance < 0 || distance < best_distance) {
      best_distance = distance;
      best_child = child;
    }
  }
  return best_child;
}

std::vector<int> VocabularyTree::Path(const std::uint8_t* descriptor) const {
  std::vector<int> path;
  int node = 0;
  while (nodes_[static_cast<std::size_t>(node)].num_children > 0) {
    node = NearestChild(nodes_[static_cast<std::size_t>(node)], descriptor);
    path.push_back(node);
  }
  return path;
}

int VocabularyTree::Word(const std::uint8_t* descriptor, int level) const {
  int word = 0;
  for (int i = 0; i < level; ++i) {
    const Node& node = nodes_[static_cast<std::size_t>(word)];
    if (node.num_children == 0) break;
    word = NearestChild(node, descriptor);
  }
  return word;
}

void VocabularyTree::VisitLeaves(const std::uint8_t* descriptor,
                                 const std::function<bool(int)>& visit) const {
  const auto size = static_cast<std::size_t>(DescriptorSize(kind_));
  using Branch = std::pair<int, int>;  // distance of the centre, node
  std::priority_queue<Branch, std::vector<Branch>, std::greater<>> branches;
  branches.push({0, 0});
  while (!branches.empty()) {
    const int node_idx = branches.top().second;
    branches.pop();
    const Node& node = nodes_[static_cast<std::size_t>(node_idx)];
    if (node.num_children == 0 && !visit(node_idx)) return;
    for (int child = node.first_child; child < node.first_child + node.num_children; ++child) {
      const std::uint8_t* centre = &centres_[static_cast<std::size_t>(child) * size];
      branches.push({DescriptorDistance(kind_, descriptor, centre), child});
    }
  }
}

std::vector<int> VocabularyTree::LeafWords(const std::vector<std::uint8_t>& descriptors,
                                           int num_threads) const {
  constexpr std::size_t kChunkSize = 1024;
  const auto size = static_cast<std::size_t>(DescriptorSize(kind_));
  std::vector<int> words(descriptors.size() / size);
  ParallelFor((words.size() + kChunkSize - 1) / kChunkSize, num_threads, [&](std::size_t chunk) {
    const std::size_t end = std::min(words.size(), (chunk + 1) * kChunkSize);
    for (std::size_t i = chunk * kChunkSize; i < end; ++i)
      words[i] = LeafWord(&descriptors[i * size]);
  });
  return words;
}

}  // namespace nightmap
