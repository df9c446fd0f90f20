// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/drift_gate.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/stages/graph/pose_graph/noisy_path.h"

namespace nightmap::drift_gate_test {

// Mean squared distance of a true loop; `rename` numbers the frames.
template <typename Rename>
double MeanSquaredDistance(PoseEdge loop, const Rename& rename) {
  constexpr int kNumTrials = 200;
  double sum = 0;
  loop.frame_a = rename(loop.frame_a);
  loop.frame_b = rename(loop.frame_b);
  for (int trial = 0; trial < kNumTrials; ++trial) {
    std::vector<PoseEdge> edges = Drive(100, static_cast<std::uint64_t>(trial));
    for (PoseEdge& edge : edges) {
      edge.frame_a = rename(edge.frame_a);
      edge.frame_b = rename(edge.frame_b);
    }
    const double distance = DriftGate(edges).Distance(loop);
    sum += distance * distance;
  }
  return sum / kNumTrials;
}

TEST(DriftGate, DistanceOfTrueLoopsIsThatOfTheDrift) {
  for (const auto& [a, b] : {std::pair(0, 20), {30, 70}, {5, 99}}) {
    const PoseEdge loop = TrueLoop(a, b);  // chi squared, 6 degrees of freedom
    EXPECT_NEAR(MeanSquaredDistance(loop, [](int i) { return i; }), 6, 0.8) << a << " " << b;
    const auto root_in_the_middle = [](int i) { return (i + 50) % 100; };
    EXPECT_NEAR(MeanSquaredDistance(loop, root_in_the_middle), 6, 0.8) << a << " " << b;
  }
}

TEST(DriftGate, IsTheSameTheOtherWayRound) {
  const DriftGate gate(Drive(60, 1));
  PoseEdge loop = TrueLoop(10, 50);
  loop.b_from_a.translation.x() += 0.2;
  loop.covariance = 1e-4 * Matrix6d::Identity();
  loop.covariance(0, 0) = 1e-2;
  PoseEdge back = loop;
  std::swap(back.frame_a, back.frame_b);
  back.b_from_a = loop.b_from_a.Inverse();
  const Matrix6d adjoint = Adjoint(back.b_from_a);
  back.covariance = adjoint * loop.covariance * adjoint.transpose();
  EXPECT_NEAR(gate.Distance(loop) / gate.Distance(back), 1, 0.03);  // to first order
}

TEST(DriftGate, AWrongPlaceIsFarAndALooseEdgeForgives) {
  std::vector<PoseEdge> edges = Drive(60, 1);
  PoseEdge loop = TrueLoop(10, 50);
  loop.b_from_a.translation.z() += 3;
  EXPECT_GT(DriftGate(edges).Distance(loop), 10);
  edges[30].covariance = 100 * Matrix6d::Identity();  // a bridge
  EXPECT_LT(DriftGate(edges).Distance(loop), 3);
}

// Distances on a joined gate, and on two trees as if joined, are those of a gate made of all edges.
TEST(DriftGate, JoinsTreesAsIfTheyAlwaysWereOne) {
  for (const int cut : {15, 45}) {  // the smaller tree moves: once the first, once the second
    const std::vector<PoseEdge> edges = Drive(60, 2);
    const PoseEdge join = edges[static_cast<std::size_t>(cut)];
    std::vector<PoseEdge> apart = edges;
    apart.erase(apart.begin() + cut);
    const DriftGate whole(edges);
    DriftGate gate(apart);
    const JoinedTrees joined(gate, join);
    const auto expect = [&](const PoseEdge& loop, double distance) {
      EXPECT_NEAR(distance / whole.Distance(loop), 1, 1e-9) << loop.frame_a << " " << loop.frame_b;
    };
    std::vector<PoseEdge> across = {TrueLoop(10, 50), TrueLoop(3, 59), TrueLoop(14, 47)};
    across.push_back(TrueLoop(2, 50));
    std::swap(across.back().frame_a, across.back().frame_b);  // whatever it measured
    for (const PoseEdge& loop : across) {
      EXPECT_EQ(gate.Distance(loop), std::numeric_limits<double>::infinity());
      expect(loop, joined.Distance(loop));
    }
    gate.Join(join);
    across.push_back(TrueLoop(1, 12));
    across.push_back(TrueLoop(50, 58));
    for (const PoseEdge& loop : across) expect(loop, gate.Distance(loop));
  }
}

}  // namespace nightmap::drift_gate_test
