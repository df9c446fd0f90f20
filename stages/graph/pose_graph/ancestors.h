// SPDX-License-Identifier: Apache-2.0
// Finds where two ways to the root of a tree meet, however long they are. A node has its parent and
// one jump to a farther ancestor, so that a climb takes a number of steps that is logarithmic in
// the depth (Myers, An applicative random-access stack, Information Processing Letters 1983).
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace nightmap {

class Ancestors {
 public:
  explicit Ancestors(std::size_t num_nodes) : nodes_(num_nodes) {
    for (std::size_t i = 0; i < num_nodes; ++i) nodes_[i] = {i, i, i, 0};
  }

  // All that hung on `node` before must be hung again, from it on.
  void Hang(std::size_t node, std::size_t parent) {
    const Node& above = nodes_[parent];
    const Node& far = nodes_[above.jump];
    const bool is_even = above.depth - far.depth == far.depth - nodes_[far.jump].depth;
    nodes_[node] = {parent, is_even ? far.jump : parent, above.root, above.depth + 1};
  }

  // A root is its own parent.
  std::size_t Parent(std::size_t node) const { return nodes_[node].parent; }
  std::size_t Root(std::size_t node) const { return nodes_[node].root; }

  // The lowest ancestor of two nodes with one root; a node is an ancestor of itself.
  std::size_t Common(std::size_t a, std::size_t b) const {
    if (nodes_[a].depth < nodes_[b].depth) std::swap(a, b);
    while (nodes_[a].depth > nodes_[b].depth) {
      const Node& node = nodes_[a];
      a = nodes_[node.jump].depth >= nodes_[b].depth ? node.jump : node.parent;
    }
    while (a != b) {
      const bool is_apart = nodes_[a].jump != nodes_[b].jump;
      a = is_apart ? nodes_[a].jump : nodes_[a].parent;
      b = is_apart ? nodes_[b].jump : nodes_[b].parent;
    }
    return a;
  }

 private:
  struct Node {
    std::size_t parent, jump, root;
    int depth;  // edges to the root
  };
  std::vector<Node> nodes_;
};

}  // namespace nightmap
