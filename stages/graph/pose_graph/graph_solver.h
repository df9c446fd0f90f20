// SPDX-License-Identifier: Apache-2.0
// Weighted least squares over a pose graph, by Gauss and Newton. A step that does not lower
// the cost is shortened, then damped (Marquardt 1963). A step costs one sparse factorization; its
// pattern is that of the edges with weight, so that loops which lost theirs cost nothing. A step is
// applied in two ways, which agree to the first order, and the one that lowers the cost more is
// taken: to each pose, or to the relative poses along a breadth-first tree of the edges. Along the
// tree a part that turns as a whole keeps its shape, so that a long way needs few steps; a large
// ring, which the tree cuts open, does better pose by pose.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/geometry/block_pattern.h"
#include "pipeline/geometry/sparse_cholesky.h"
#include "stages/graph/pose_graph/edge_error.h"

namespace nightmap {

struct GraphSummary {
  double initial_cost = 0;  // half the weighted sum of squared Mahalanobis distances
  double final_cost = 0;
  int num_steps = 0;
  bool has_converged = false;
};

class GraphSolver {
 public:
  // `world_from_node` by index of its frame; the first is held fixed, as only relative poses are
  // measured. Edges that never lack weight connect all. Throws DataError when the system is too
  // large.
  GraphSolver(const std::vector<PoseEdge>& edges, const std::map<int, Rigid3>& world_from_node);

  // Moves the poses by at most `max_steps` steps, `weights` in the order of the edges. Throws
  // DataError when a factor does not fit into memory or the cost is not a number. Deterministic;
  // one thread.
  GraphSummary Solve(const std::vector<double>& weights, int max_steps);

  // Mahalanobis distance between the measured and the actual b_from_a of an edge.
  double Error(std::size_t edge) const;

  const std::vector<Rigid3>& Poses() const { return poses_; }  // in the order of their frames

 private:
  struct Ends {
    std::size_t a = 0, b = 0;
    bool is_in_layout = false;
    bool is_a_later = false;
    std::ptrdiff_t slot = -1;  // of the block (later, earlier) in the values; -1: an end is fixed
  };

  bool FitsLayout(const std::vector<double>& weights) const;
  void Layout(const std::vector<double>& weights);
  void FindTree(const std::vector<std::vector<int>>& neighbours);
  void FindSlots();
  void Linearize(const std::vector<double>& weights);
  void Add(const Ends& ends, double weight, const EdgeError::Linear& linear);
  struct Trial {
    std::vector<Rigid3> poses;
    double cost;
  };

  Trial Try(const std::vector<double>& weights, const Eigen::VectorXd& step) const;
  double TakeStep(const std::vector<double>& weights, double cost);
  std::optional<Eigen::VectorXd> Step(double damping);
  std::vector<Rigid3> Moved(const Eigen::VectorXd& step) const;
  std::vector<Rigid3> MovedAlongTree(const Eigen::VectorXd& step) const;
  Vector6d StepOf(const Eigen::VectorXd& step, std::size_t node) const;
  double Cost(const std::vector<double>& weights, const std::vector<Rigid3>& poses) const;

  std::vector<Rigid3> poses_;
  std::vector<EdgeError> errors_;
  std::vector<Ends> ends_;
  std::vector<std::pair<std::size_t, std::size_t>> tree_;  // parent and child, parents first
  BlockPattern pattern_;
  std::vector<Matrix6d> diagonal_;  // by rank, as the gradient
  Eigen::VectorXd gradient_;
  SparseCholesky cholesky_;
  double damping_;  // of the next step
};

}  // namespace nightmap
