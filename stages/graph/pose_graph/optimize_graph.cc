// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/optimize_graph.h"

#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

constexpr int kMaxRounds = 40;
constexpr int kMaxSteps = 30;  // over the accepted edges; a round of the graduation takes one
constexpr double kMinMuFactor = 1.6;
// From the first control value to 1, however far off the worst loop is: a long night begins at a
// millionth.
constexpr double kGraduationRounds = 12;

// Equation 14 of the paper: the weight of a truncated squared error at control value mu.
double Weight(double error, double max_error, double mu) {
  const double error2 = error * error;
  const double max_error2 = max_error * max_error;
  if (error2 >= (mu + 1) / mu * max_error2) return 0;
  if (error2 <= mu / (mu + 1) * max_error2) return 1;
  return max_error / error * std::sqrt(mu * (mu + 1)) - mu;
}

bool IsDecided(const GraphEdge& edge) {
  return !edge.is_loop || edge.weight < 1e-3 || edge.weight > 1 - 1e-3;
}

class Graduation {
 public:
  Graduation(double max_loop_error, std::vector<GraphEdge>* edges, GraphSolver* solver)
      : max_loop_error_(max_loop_error), edges_(*edges), solver_(*solver) {}

  // The odometry is believed from the start, loops only as far as they agree with it: least squares
  // over all of them would bend the map along those that are wrong.
  GraduationSummary Run() {
    UpdateErrors();
    double mu = FirstMu();
    const double factor = std::max(kMinMuFactor, std::pow(mu, -1 / kGraduationRounds));
    int num_rounds = 0;
    for (; num_rounds < kMaxRounds; ++num_rounds, mu *= factor) {
      for (GraphEdge& edge : edges_) {
        if (edge.is_loop) edge.weight = Weight(edge.error, max_loop_error_, mu);
      }
      if (num_rounds > 1 && std::ranges::all_of(edges_, IsDecided)) break;
      Solve(1);
    }
    for (GraphEdge& edge : edges_) {
      if (edge.is_loop) edge.weight = edge.error <= max_loop_error_ ? 1 : 0;
    }
    return {num_rounds, Solve(kMaxSteps)};
  }

 private:
  GraphSummary Solve(int max_steps) {
    std::vector<double> weights;
    for (const GraphEdge& edge : edges_) weights.push_back(edge.weight);
    GraphSummary summary = solver_.Solve(weights, max_steps);
    UpdateErrors();
    return summary;
  }

  void UpdateErrors() {
    for (std::size_t i = 0; i < edges_.size(); ++i) edges_[i].error = solver_.Error(i);
  }

  // At which the cost of the worst loop is still convex.
  double FirstMu() const {
    double worst = 0;
    for (const GraphEdge& edge : edges_) {
      if (edge.is_loop) worst = std::max(worst, edge.error);
    }
    const double max_error2 = max_loop_error_ * max_loop_error_;
    const double denominator = 2 * worst * worst - max_error2;
    return denominator > 0 ? std::max(1e-6, max_error2 / denominator) : 1e6;
  }

  double max_loop_error_;
  std::vector<GraphEdge>& edges_;
  GraphSolver& solver_;
};

}  // namespace

double ErrorOf(const PoseEdge& edge, const Rigid3& world_from_a, const Rigid3& world_from_b) {
  return EdgeError(edge).Residual(world_from_a, world_from_b).norm();
}

GraduationSummary OptimizeGraph(double max_loop_error,
                                std::vector<GraphEdge>* edges,
                                std::map<int, Rigid3>* poses) {
  std::vector<PoseEdge> measured;
  for (const GraphEdge& edge : *edges) measured.push_back(edge.edge);
  GraphSolver solver(measured, *poses);
  GraduationSummary summary = Graduation(max_loop_error, edges, &solver).Run();
  auto pose = solver.Poses().begin();
  for (auto& [frame_idx, moved] : *poses) moved = *pose++;
  return summary;
}

}  // namespace nightmap
