// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace nightmap {

// Central differences of a function of vectors.
template <typename Function>
Eigen::MatrixXd NumericDerivative(const Function& function, const Eigen::VectorXd& at) {
  constexpr double kStep = 1e-5;
  Eigen::MatrixXd derivative(function(at).size(), at.size());
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(at.size(), i);
    derivative.col(i) = (function(at + step) - function(at - step)) / (2 * kStep);
  }
  return derivative;
}

}  // namespace nightmap
