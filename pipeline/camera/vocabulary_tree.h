// SPDX-License-Identifier: Apache-2.0
// Vocabulary tree (Nister and Stewenius, CVPR 2006) by hierarchical k-means, with word assignment
// at any level for active search. Inside a node the assignment is exact: with 10 branches a search
// structure over the centres (the approximate k-means of flat vocabularies) costs more than it
// saves. All distances and means are integers, so the tree does not depend on the number of threads
// or on the machine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/io/features_io.h"

namespace nightmap {

struct VocabularyTreeOptions {
  int branching = 10;
  static constexpr int kMaxDepth = 8;
  int depth = 5;  // levels below the root
  int num_kmeans_iterations = 8;
  int min_node_descriptors = 20;  // a node trained on fewer descriptors is a leaf
  int seed = 0;
};

// Node 0 is the root; the children of a node are contiguous. A word at level L is the node at depth
// L below the root on the descriptor's path (or the leaf, when the path ends earlier).
class VocabularyTree {
 public:
  // Descriptors are num x descriptor_size bytes. k-means++ seeding (Arthur and Vassilvitskii, SODA
  // 2007), then Lloyd's iterations; k-medians by bitwise majority for ORB and BRISK. Deterministic
  // at any number of threads. Throws DataError without descriptors.
  static VocabularyTree Train(const std::vector<std::uint8_t>& descriptors,
                              DescriptorKind kind,
                              const VocabularyTreeOptions& options,
                              int num_threads);

  // Leaf of each descriptor; the same at any number of threads.
  std::vector<int> LeafWords(const std::vector<std::uint8_t>& descriptors, int num_threads) const;

  // Node ids on the path of a descriptor, levels 1..depth (shorter when a leaf comes earlier).
  std::vector<int> Path(const std::uint8_t* descriptor) const;
  // Node at `level`, or the leaf if the path is shorter.
  int Word(const std::uint8_t* descriptor, int level) const;
  // Calls visit(leaf) for leaves in approximate order of distance until it returns false or every
  // leaf was visited. Best branch first: the next branch is the one with the nearest centre among
  // all branches passed by (Muja and Lowe, VISAPP 2009).
  void VisitLeaves(const std::uint8_t* descriptor, const std::function<bool(int)>& visit) const;
  int LeafWord(const std::uint8_t* descriptor) const { return Word(descriptor, depth_); }
  int NumNodes() const;
  int Depth() const;
  DescriptorKind Kind() const;

  // Arrays as stored in vocabulary.h5 (see vocabulary_io.h).
  struct Node {
    int first_child = 0;  // 0: leaf
    int num_children = 0;
    int level = 0;
  };
  VocabularyTree() = default;
  // Throws std::invalid_argument naming the array when these do not form a tree: nodes breadth
  // first, every node except the root the child of exactly one other, levels consecutive and at
  // most `depth`.
  VocabularyTree(DescriptorKind kind,
                 int depth,
                 std::vector<Node> nodes,
                 std::vector<std::uint8_t> centres);
  const std::vector<Node>& Nodes() const { return nodes_; }
  const std::vector<std::uint8_t>& Centres() const { return centres_; }

 private:
  int NearestChild(const Node& node, const std::uint8_t* descriptor) const;

  DescriptorKind kind_ = DescriptorKind::kRootSift;
  int depth_ = 0;
  std::vector<Node> nodes_;
  std::vector<std::uint8_t> centres_;  // descriptor_size bytes per node (root: zeros)
};

}  // namespace nightmap
