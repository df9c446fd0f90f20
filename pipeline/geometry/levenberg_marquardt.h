// SPDX-License-Identifier: Apache-2.0
// Dense robust least squares with few unknowns, whose number is known at compile time: Levenberg's
// damping with Marquardt's scaling (SIAM J. Appl. Math. 1963) on iteratively reweighted residuals.
// For many poses and points use AdjustBundle.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

namespace nightmap {

template <int kSize>
struct NormalEquations {
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  Matrix hessian = Matrix::Zero();
  Vector gradient = Vector::Zero();
  double cost = 0;

  // Adds a residual over its standard deviation, under Cauchy's loss with a constant of 2
  // deviations.
  template <int kRows>
  void AddRobust(const Eigen::Matrix<double, kRows, kSize>& jacobian,
                 const Eigen::Matrix<double, kRows, 1>& residual) {
    constexpr double kScale2 = 4.0;
    const double weight = 1 / (1 + residual.squaredNorm() / kScale2);
    hessian += weight * jacobian.transpose() * jacobian;
    gradient += weight * jacobian.transpose() * residual;
    cost += kScale2 * std::log1p(residual.squaredNorm() / kScale2);
  }

  // Adds a prior that the unknowns, now at `values`, are zero; `weights` are inverse variances.
  void AddPrior(const Vector& weights, const Vector& values) {
    hessian.diagonal() += weights;
    gradient += weights.cwiseProduct(values);
    cost += values.dot(weights.cwiseProduct(values));
  }

  // Inverse of the Hessian; nothing when the residuals do not determine the unknowns.
  std::optional<Matrix> Covariance() const {
    const Eigen::LDLT<Matrix> factors(hessian);
    if (factors.info() != Eigen::Success || factors.vectorD().minCoeff() < 1e-6) return {};
    return factors.solve(Matrix::Identity());
  }
};

struct SmallSolverOptions {
  int max_steps = 20;   // tried steps
  double min_step = 0;  // the first accepted step that is shorter is the last
  double min_gain = 0;  // likewise the first step whose relative decrease of the cost is smaller
};

// Minimizes the cost from `state`. `build(state)` returns the normal equations there, `move(step,
// state)` the state after a step. Deterministic. A step that is not a number ends it.
template <int kSize, typename State, typename Build, typename Move>
State MinimizeSmall(const SmallSolverOptions& options,
                    State state,
                    const Build& build,
                    const Move& move) {
  NormalEquations<kSize> here = build(state);
  double damping = 1e-4;
  for (int step = 0; step < options.max_steps; ++step) {
    typename NormalEquations<kSize>::Matrix damped = here.hessian;
    damped.diagonal() *= 1 + damping;
    const typename NormalEquations<kSize>::Vector update = -damped.ldlt().solve(here.gradient);
    if (!update.allFinite()) break;
    const State candidate = move(update, state);
    const NormalEquations<kSize> there = build(candidate);
    if (!(there.cost < here.cost)) {  // also true where a cost is NaN
      damping *= 10;
      continue;
    }
    const bool is_last =
        update.norm() < options.min_step || there.cost > (1 - options.min_gain) * here.cost;
    state = candidate;
    here = there;
    if (is_last) break;
    damping = std::max(1e-9, damping / 10);
  }
  return state;
}

}  // namespace nightmap
