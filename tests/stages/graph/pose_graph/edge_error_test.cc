// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/edge_error.h"

#include <gtest/gtest.h>

#include "tests/stages/graph/pose_graph/graph_scene.h"

namespace nightmap::edge_error_test {

TEST(EdgeError, IsZeroWherePosesFitAndTheSameForBothSignsOfAQuaternion) {
  const GraphScene scene = MakeGraphScene(0);
  for (const PoseEdge& edge : scene.edges) {
    Rigid3 a = scene.truth.at(edge.frame_a);
    const Rigid3& b = scene.truth.at(edge.frame_b);
    EXPECT_LT(EdgeError(edge).Residual(a, b).norm(), 1e-10);
    const Rigid3 moved = scene.start.at(edge.frame_b);
    const Vector6d residual = EdgeError(edge).Residual(a, moved);
    a.rotation.coeffs() *= -1;
    EXPECT_LT((EdgeError(edge).Residual(a, moved) - residual).norm(), 1e-10);
  }
}

TEST(EdgeError, DerivativesAreThoseOfTheResidual) {
  constexpr double kStep = 1e-6;
  const GraphScene scene = MakeGraphScene(0.3);
  for (const PoseEdge& edge : scene.edges) {
    const EdgeError error(edge);
    const Rigid3 a = scene.start.at(edge.frame_a);
    const Rigid3 b = scene.start.at(edge.frame_b);
    const EdgeError::Linear linear = error.Linearize(a, b);
    EXPECT_LT((linear.residual - error.Residual(a, b)).norm(), 1e-12);
    for (int i = 0; i < 6; ++i) {
      const Rigid3 there = PerturbLeft(kStep * Vector6d::Unit(i), Rigid3());
      const Rigid3 back = PerturbLeft(-kStep * Vector6d::Unit(i), Rigid3());
      const Vector6d by_a =
          (error.Residual(a * there, b) - error.Residual(a * back, b)) / (2 * kStep);
      const Vector6d by_b =
          (error.Residual(a, b * there) - error.Residual(a, b * back)) / (2 * kStep);
      EXPECT_LT((linear.by_a.col(i) - by_a).norm(), 1e-6 * linear.by_a.norm());
      EXPECT_LT((linear.by_b.col(i) - by_b).norm(), 1e-6 * linear.by_b.norm());
    }
  }
}

}  // namespace nightmap::edge_error_test
