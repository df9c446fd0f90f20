// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/graph_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr double kMinDamping = 1e-13;  // keeps what no edge holds where it is
constexpr double kMaxDamping = 1e3;
constexpr double kMinLength = 1.0 / 16;  // of a step, as a share of the one that was found
constexpr double kMinGain = 1e-6;        // of the cost; a smaller one is the last
constexpr double kRounding = 1e-9;       // of the cost
constexpr double kNoCost = 1e-12;        // per edge: rounding
constexpr double kMinWeight = 1e-6;      // edges below it are left out
constexpr std::size_t kMaxIdle = 10;     // a layout has at most one edge of so many without weight

std::vector<std::vector<int>> Neighbours(std::size_t num_nodes,
                                         const std::vector<std::pair<int, int>>& pairs) {
  std::vector<std::vector<int>> neighbours(num_nodes);
  for (const auto& [a, b] : pairs) {
    neighbours[static_cast<std::size_t>(a)].push_back(b);
    neighbours[static_cast<std::size_t>(b)].push_back(a);
  }
  for (std::vector<int>& others : neighbours) {
    std::ranges::sort(others);
    others.erase(std::unique(others.begin(), others.end()), others.end());
  }
  return neighbours;
}

}  // namespace

GraphSolver::GraphSolver(const std::vector<PoseEdge>& edges,
                         const std::map<int, Rigid3>& world_from_node)
    : cholesky_("use a machine with more memory, or map the recording in parts"),
      damping_(kMinDamping) {
  std::map<int, std::size_t> index;
  for (const auto& [frame_idx, pose] : world_from_node) {
    index.emplace_hint(index.end(), frame_idx, poses_.size());
    poses_.push_back(pose);
  }
  for (const PoseEdge& edge : edges) {
    errors_.emplace_back(edge);
    ends_.push_back({index.at(edge.frame_a), index.at(edge.frame_b)});
  }
}

// Whether all edges with weight are in the layout, and most others are not.
bool GraphSolver::FitsLayout(const std::vector<double>& weights) const {
  std::size_t num_idle = 0;
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    const bool has_weight = weights[i] >= kMinWeight;
    if (has_weight && !ends_[i].is_in_layout) return false;
    num_idle += !has_weight && ends_[i].is_in_layout;
  }
  return num_idle <= ends_.size() / kMaxIdle;
}

void GraphSolver::Layout(const std::vector<double>& weights) {
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    Ends& ends = ends_[i];
    ends.is_in_layout = weights[i] >= kMinWeight;
    if (!ends.is_in_layout) continue;
    pairs.emplace_back(static_cast<int>(ends.a), static_cast<int>(ends.b));
  }
  auto neighbours = Neighbours(poses_.size(), pairs);
  FindTree(neighbours);
  for (std::vector<int>& others : neighbours) std::erase(others, 0);  // the first pose is fixed
  neighbours.front().clear();
  std::vector<bool> is_free(poses_.size(), true);
  is_free[0] = false;
  pattern_ = MakeBlockPattern(is_free, neighbours, 6, 0);
  diagonal_.resize(poses_.size() - 1);
  gradient_.resize(pattern_.lower.rows());
  FindSlots();
  cholesky_.Analyze(pattern_.lower);
}

void GraphSolver::FindSlots() {
  const auto by_rank = [&](int pose) { return pattern_.rank[static_cast<std::size_t>(pose)]; };
  for (Ends& ends : ends_) {
    if (!ends.is_in_layout || ends.a == 0 || ends.b == 0) continue;
    ends.is_a_later = pattern_.rank[ends.a] > pattern_.rank[ends.b];
    const std::size_t earlier = ends.is_a_later ? ends.b : ends.a;
    const int later = pattern_.rank[ends.is_a_later ? ends.a : ends.b];
    const std::vector<int>& all = pattern_.later[earlier];
    const auto block = std::ranges::lower_bound(all, later, {}, by_rank) - all.begin();
    ends.slot = pattern_.lower.outerIndexPtr()[6 * pattern_.rank[earlier]] + 6 * (block + 1);
  }
}

void GraphSolver::FindTree(const std::vector<std::vector<int>>& neighbours) {
  tree_.clear();
  std::vector<bool> is_reached(poses_.size(), false);
  is_reached[0] = true;
  std::vector<std::size_t> reached = {0};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const std::size_t parent = reached[i];
    for (const int neighbour : neighbours[parent]) {
      const auto child = static_cast<std::size_t>(neighbour);
      if (is_reached[child]) continue;
      is_reached[child] = true;
      tree_.emplace_back(parent, child);
      reached.push_back(child);
    }
  }
}

GraphSummary GraphSolver::Solve(const std::vector<double>& weights, int max_steps) {
  if (poses_.size() > 1 && !FitsLayout(weights)) Layout(weights);
  GraphSummary summary;
  double cost = summary.initial_cost = Cost(weights, poses_);
  const double no_cost = kNoCost * static_cast<double>(ends_.size());
  while (poses_.size() > 1 && summary.num_steps < max_steps && !summary.has_converged) {
    Linearize(weights);
    const double gain = TakeStep(weights, cost);
    summary.has_converged = gain <= kMinGain * cost + no_cost;
    cost -= gain;
    ++summary.num_steps;
  }
  summary.final_cost = cost;
  return summary;
}

// Returns by how much the cost falls; 0: no step is expected to lower it by more than rounding.
double GraphSolver::TakeStep(const std::vector<double>& weights, double cost) {
  const double no_gain = kRounding * cost + kNoCost * static_cast<double>(ends_.size());
  for (; damping_ < kMaxDamping; damping_ *= 100) {
    const auto step = Step(damping_);
    if (!step) continue;
    Trial best = Try(weights, *step);
    for (double length = 0.5; best.cost >= cost && length >= kMinLength; length /= 2) {
      best = Try(weights, length * *step);
    }
    if (best.cost < cost) {
      poses_ = std::move(best.poses);
      damping_ = std::max(kMinDamping, damping_ / 100);
      return cost - best.cost;
    }
    if (-gradient_.dot(*step) / 2 <= no_gain) return 0;
  }
  throw DataError(
      "the graph of {} keyframes and {} edges was not optimized: no step lowers its cost of {}; "
      "delete the odometry and matches folders of this site and run make",
      poses_.size(),
      ends_.size(),
      cost);
}

// The better of the two ways to apply a step.
GraphSolver::Trial GraphSolver::Try(const std::vector<double>& weights,
                                    const Eigen::VectorXd& step) const {
  Trial one_by_one{Moved(step), 0}, along_tree{MovedAlongTree(step), 0};
  one_by_one.cost = Cost(weights, one_by_one.poses);
  along_tree.cost = Cost(weights, along_tree.poses);
  return along_tree.cost < one_by_one.cost ? std::move(along_tree) : std::move(one_by_one);
}

double GraphSolver::Error(std::size_t edge) const {
  return errors_[edge].Residual(poses_[ends_[edge].a], poses_[ends_[edge].b]).norm();
}

void GraphSolver::Linearize(const std::vector<double>& weights) {
  std::ranges::fill(diagonal_, Matrix6d::Zero());
  gradient_.setZero();
  std::fill_n(pattern_.lower.valuePtr(), pattern_.lower.nonZeros(), 0.0);
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    if (weights[i] < kMinWeight) continue;
    Add(ends_[i], weights[i], errors_[i].Linearize(poses_[ends_[i].a], poses_[ends_[i].b]));
  }
}

void GraphSolver::Add(const Ends& ends, double weight, const EdgeError::Linear& linear) {
  const auto add_to = [&](std::size_t node, const Matrix6d& jacobian) {
    if (node == 0) return;
    const int rank = pattern_.rank[node];
    diagonal_[static_cast<std::size_t>(rank)] += weight * jacobian.transpose() * jacobian;
    gradient_.segment<6>(6 * rank) += weight * jacobian.transpose() * linear.residual;
  };
  add_to(ends.a, linear.by_a);
  add_to(ends.b, linear.by_b);
  if (ends.slot < 0) return;
  const Matrix6d& later = ends.is_a_later ? linear.by_a : linear.by_b;
  const Matrix6d& earlier = ends.is_a_later ? linear.by_b : linear.by_a;
  const int rank = pattern_.rank[ends.is_a_later ? ends.b : ends.a];
  const int* const columns = pattern_.lower.outerIndexPtr() + 6 * rank;
  Eigen::Map<Matrix6d, 0, Eigen::OuterStride<>>(pattern_.lower.valuePtr() + ends.slot,
                                                Eigen::OuterStride<>(columns[1] - columns[0])) +=
      weight * later.transpose() * earlier;
}

// The step of the linearized graph, by rank; nothing where the damped system is not positive
// definite.
std::optional<Eigen::VectorXd> GraphSolver::Step(double damping) {
  for (std::size_t rank = 0; rank < diagonal_.size(); ++rank) {
    Matrix6d damped = diagonal_[rank];
    damped.diagonal() *= 1 + damping;
    const int* const columns = pattern_.lower.outerIndexPtr() + 6 * rank;
    Eigen::Map<Matrix6d, 0, Eigen::OuterStride<>>(pattern_.lower.valuePtr() + columns[0],
                                                  Eigen::OuterStride<>(columns[1] - columns[0])) =
        damped;
  }
  return cholesky_.Solve(pattern_.lower, -gradient_);
}

// Each pose after a step.
std::vector<Rigid3> GraphSolver::Moved(const Eigen::VectorXd& step) const {
  std::vector<Rigid3> moved = poses_;
  for (std::size_t node = 1; node < moved.size(); ++node) {
    moved[node] = poses_[node] * PerturbLeft(StepOf(step, node), Rigid3());
  }
  return moved;
}

// The same to the first order: relative poses along the tree move by as much as the step moves one
// end against the other.
std::vector<Rigid3> GraphSolver::MovedAlongTree(const Eigen::VectorXd& step) const {
  std::vector<Rigid3> moved = poses_;
  for (const auto& [parent, child] : tree_) {
    const Rigid3 child_from_parent = poses_[child].Inverse() * poses_[parent];
    const Vector6d relative =
        StepOf(step, child) - Adjoint(child_from_parent) * StepOf(step, parent);
    moved[child] = moved[parent] * child_from_parent.Inverse() * PerturbLeft(relative, Rigid3());
  }
  return moved;
}

Vector6d GraphSolver::StepOf(const Eigen::VectorXd& step, std::size_t node) const {
  if (node == 0) return Vector6d::Zero();
  return step.segment<6>(6 * pattern_.rank[node]);
}

double GraphSolver::Cost(const std::vector<double>& weights,
                         const std::vector<Rigid3>& poses) const {
  double cost = 0;
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    if (weights[i] < kMinWeight) continue;
    cost +=
        weights[i] / 2 * errors_[i].Residual(poses[ends_[i].a], poses[ends_[i].b]).squaredNorm();
  }
  return cost;
}

}  // namespace nightmap
