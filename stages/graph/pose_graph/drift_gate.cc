// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/drift_gate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace nightmap {
namespace {

constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

// Ascending.
std::vector<int> EndsOf(const std::vector<PoseEdge>& tree, const std::vector<PoseEdge>& others) {
  std::vector<int> ends;
  for (const auto* edges : {&tree, &others}) {
    for (const PoseEdge& edge : *edges) {
      ends.push_back(edge.frame_a);
      ends.push_back(edge.frame_b);
    }
  }
  std::ranges::sort(ends);
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

// `drift`: covariance of the motion between both cameras, in the world.
double Mahalanobis(const PoseEdge& loop,
                   const Rigid3& world_from_a,
                   const Rigid3& world_from_b,
                   const Matrix6d& drift) {
  const Rigid3 b_from_world = world_from_b.Inverse();
  const Matrix6d adjoint = Adjoint(b_from_world);
  const Matrix6d covariance = adjoint * drift * adjoint.transpose() + loop.covariance;
  const Rigid3 difference = b_from_world * world_from_a * loop.b_from_a.Inverse();
  const Eigen::AngleAxisd rotation(difference.rotation);
  Vector6d error;
  error << rotation.angle() * rotation.axis(), difference.translation;
  return std::sqrt(error.dot(covariance.ldlt().solve(error)));
}

}  // namespace

DriftGate::DriftGate(std::vector<PoseEdge> tree, const std::vector<PoseEdge>& others)
    : tree_(std::move(tree)),
      frames_(EndsOf(tree_, others)),
      keyframes_(frames_.size()),
      edges_of_(frames_.size()),
      ancestors_(frames_.size()),
      num_keyframes_(frames_.size(), 0) {
  if (!frames_.empty()) place_of_.resize(static_cast<std::size_t>(frames_.back()) + 1, kNowhere);
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    place_of_[static_cast<std::size_t>(frames_[i])] = i;
  }
  for (std::size_t i = 0; i < tree_.size(); ++i) Link(i);
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    if (ancestors_.Root(i) == i) PlaceAllFrom(i);
    ++num_keyframes_[ancestors_.Root(i)];
  }
}

std::size_t DriftGate::PlaceOf(int frame) const {
  return place_of_.at(static_cast<std::size_t>(frame));
}

void DriftGate::Link(std::size_t edge_idx) {
  edges_of_.at(PlaceOf(tree_[edge_idx].frame_a)).push_back(edge_idx);
  edges_of_.at(PlaceOf(tree_[edge_idx].frame_b)).push_back(edge_idx);
}

// The other end of an edge.
void DriftGate::Place(std::size_t from, const PoseEdge& edge) {
  const std::size_t a = PlaceOf(edge.frame_a);
  const bool is_forward = a == from;
  const std::size_t other = is_forward ? PlaceOf(edge.frame_b) : a;
  ancestors_.Hang(other, from);
  const Keyframe& known = keyframes_[from];
  Keyframe& to = keyframes_[other];
  to.world_from_camera =
      known.world_from_camera * (is_forward ? edge.b_from_a.Inverse() : edge.b_from_a);
  const Matrix6d adjoint = Adjoint(is_forward ? to.world_from_camera : known.world_from_camera);
  to.covariance = known.covariance + adjoint * edge.covariance * adjoint.transpose();
}

// All that hangs on a keyframe whose place is known.
void DriftGate::PlaceAllFrom(std::size_t root) {
  std::vector<std::size_t> reached = {root};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const std::size_t from = reached[i];
    for (const std::size_t edge_idx : edges_of_[from]) {
      const PoseEdge& edge = tree_[edge_idx];
      const std::size_t a = PlaceOf(edge.frame_a);
      const std::size_t other = a == from ? PlaceOf(edge.frame_b) : a;
      if (other == ancestors_.Parent(from)) continue;
      Place(from, edge);
      reached.push_back(other);
    }
  }
}

std::pair<std::size_t, std::size_t> DriftGate::TreesOf(const PoseEdge& edge) const {
  return std::minmax({TreeOf(edge.frame_a), TreeOf(edge.frame_b)});
}

void DriftGate::Join(const PoseEdge& edge) {
  tree_.push_back(edge);
  Link(tree_.size() - 1);
  std::size_t stays = PlaceOf(edge.frame_a);
  std::size_t moves = PlaceOf(edge.frame_b);
  const auto size = [&](std::size_t end) { return num_keyframes_[ancestors_.Root(end)]; };
  if (size(stays) < size(moves)) std::swap(stays, moves);
  num_keyframes_[ancestors_.Root(stays)] += size(moves);
  Place(stays, tree_.back());
  PlaceAllFrom(moves);
}

// Covariance of the motion between the two, in the world.
Matrix6d DriftGate::Drift(int frame_a, int frame_b) const {
  const std::size_t a = PlaceOf(frame_a);
  const std::size_t b = PlaceOf(frame_b);
  const Matrix6d both = keyframes_.at(a).covariance + keyframes_.at(b).covariance;
  return both - 2 * keyframes_[ancestors_.Common(a, b)].covariance;
}

double DriftGate::Distance(const PoseEdge& loop) const {
  const auto [a, b] = TreesOf(loop);
  if (a != b) return std::numeric_limits<double>::infinity();
  return Mahalanobis(
      loop, PoseOf(loop.frame_a), PoseOf(loop.frame_b), Drift(loop.frame_a, loop.frame_b));
}

std::map<int, Rigid3> DriftGate::Poses() const {
  std::map<int, Rigid3> poses;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    poses.emplace_hint(poses.end(), frames_[i], keyframes_[i].world_from_camera);
  }
  return poses;
}

JoinedTrees::JoinedTrees(const DriftGate& gate, const PoseEdge& join) : gate_(gate), join_(join) {
  const Rigid3& world_from_b = gate_.PoseOf(join_.frame_b);
  b_from_a_ = world_from_b * join_.b_from_a * gate_.PoseOf(join_.frame_a).Inverse();
  adjoint_ = Adjoint(b_from_a_);
  const Matrix6d from_b = Adjoint(world_from_b);
  covariance_ = from_b * join_.covariance * from_b.transpose();
}

double JoinedTrees::Distance(const PoseEdge& loop) const {
  const bool is_forward = gate_.TreeOf(loop.frame_a) == gate_.TreeOf(join_.frame_a);
  const int a = is_forward ? loop.frame_a : loop.frame_b;  // in the tree of the edge's frame_a
  const int b = is_forward ? loop.frame_b : loop.frame_a;
  const Matrix6d drift = gate_.Drift(join_.frame_b, b) + covariance_ +
                         adjoint_ * gate_.Drift(join_.frame_a, a) * adjoint_.transpose();
  const Rigid3 world_from_a = b_from_a_ * gate_.PoseOf(a);
  const Rigid3& world_from_b = gate_.PoseOf(b);
  return is_forward ? Mahalanobis(loop, world_from_a, world_from_b, drift)
                    : Mahalanobis(loop, world_from_b, world_from_a, drift);
}

}  // namespace nightmap
