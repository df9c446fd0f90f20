// SPDX-License-Identifier: Apache-2.0
// Tests whether a loop can be true, given how far the odometry may have drifted between its ends.
// In a building with repeated parts, false loops may agree with each other and outnumber the true
// ones; this test tells them apart before any optimization.
#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "pipeline/io/odometry_io.h"
#include "stages/graph/pose_graph/ancestors.h"

namespace nightmap {

// Covariances of the edges between two keyframes add up in the world frame, to first order (Barfoot
// and Furgale, Associating uncertainty with three-dimensional poses, T-RO 2014). A distance takes
// time that is logarithmic in the number of keyframes.
class DriftGate {
 public:
  // `tree` has edges without a cycle: one tree or several. Each tree's world is its lowest
  // keyframe. The ends of `others` are keyframes too, if need be each a tree of its own.
  explicit DriftGate(std::vector<PoseEdge> tree, const std::vector<PoseEdge>& others = {});

  // Mahalanobis distance of the loop from the tree that both its ends are in, under the uncertainty
  // of both; infinite where they are in two trees.
  double Distance(const PoseEdge& loop) const;

  // The trees of both ends, in any order that is the same for all edges between them.
  std::pair<std::size_t, std::size_t> TreesOf(const PoseEdge& edge) const;

  // Makes two trees one, in the world of the larger one: distances are those of a new gate but for
  // rounding. All joins of n keyframes together take the time of n log n.
  void Join(const PoseEdge& edge);

  // world_from_camera of every keyframe.
  std::map<int, Rigid3> Poses() const;

  // The edges given and joined, in this order.
  std::vector<PoseEdge> TakeTree() && { return std::move(tree_); }

 private:
  friend class JoinedTrees;

  struct Keyframe {
    Rigid3 world_from_camera;
    // Relative to the root, a left perturbation in the world.
    Matrix6d covariance = Matrix6d::Zero();
  };

  std::size_t PlaceOf(int frame) const;
  const Rigid3& PoseOf(int frame) const { return keyframes_[PlaceOf(frame)].world_from_camera; }
  std::size_t TreeOf(int frame) const { return ancestors_.Root(PlaceOf(frame)); }
  Matrix6d Drift(int frame_a, int frame_b) const;
  void Link(std::size_t edge_idx);
  void Place(std::size_t from, const PoseEdge& edge);
  void PlaceAllFrom(std::size_t root);

  std::vector<PoseEdge> tree_;
  std::vector<int> frames_;            // of the keyframes, ascending
  std::vector<std::size_t> place_of_;  // among them, by frame
  std::vector<Keyframe> keyframes_;
  std::vector<std::vector<std::size_t>> edges_of_;  // indices into tree_, by keyframe
  Ancestors ancestors_;
  std::vector<std::size_t> num_keyframes_;  // of the tree, by root
};

// Two trees of a gate as if one more edge joined them. The gate and the edge must outlive it.
class JoinedTrees {
 public:
  JoinedTrees(const DriftGate& gate, const PoseEdge& join);

  // Likewise of a loop between the two trees; what a gate of the joined tree would say, but for
  // rounding.
  double Distance(const PoseEdge& loop) const;

 private:
  const DriftGate& gate_;
  const PoseEdge& join_;
  Rigid3 b_from_a_;  // from the world of the tree of the edge's frame_a to that of frame_b
  Matrix6d adjoint_;
  Matrix6d covariance_;  // of the edge, in the latter
};

}  // namespace nightmap
