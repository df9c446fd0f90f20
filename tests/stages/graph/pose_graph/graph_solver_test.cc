// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/graph_solver.h"

#include <limits>
#include <numbers>

#include "tests/stages/graph/pose_graph/graph_scene.h"
#include "tests/test_data.h"

namespace nightmap::graph_solver_test {

constexpr int kMaxSteps = 50;

std::vector<double> Ones(const GraphScene& scene) {
  return std::vector<double>(scene.edges.size(), 1);
}

TEST(GraphSolver, ExactEdgesGiveTheTruth) {
  const GraphScene scene = MakeGraphScene(0);
  GraphSolver solver(scene.edges, scene.start);
  const GraphSummary summary = solver.Solve(Ones(scene), kMaxSteps);
  EXPECT_TRUE(summary.has_converged);
  EXPECT_LT(summary.final_cost, 1e-9 * summary.initial_cost);
  auto pose = solver.Poses().begin();
  for (const auto& [idx, truth] : scene.truth) {
    EXPECT_LT((pose->translation - truth.translation).norm(), 1e-5);
    EXPECT_LT(AngleBetween_rad(*pose++, truth), 1e-5);
  }
}

double Cost(const GraphScene& scene, const std::map<int, Rigid3>& poses) {
  double cost = 0;
  for (const PoseEdge& edge : scene.edges) {
    cost +=
        EdgeError(edge).Residual(poses.at(edge.frame_a), poses.at(edge.frame_b)).squaredNorm() / 2;
  }
  return cost;
}

TEST(GraphSolver, NoMoveOfAPoseLowersTheCost) {
  const GraphScene scene = MakeGraphScene(0.1);
  GraphSolver solver(scene.edges, scene.start);
  const GraphSummary summary = solver.Solve(Ones(scene), kMaxSteps);
  EXPECT_TRUE(summary.has_converged);
  std::map<int, Rigid3> poses = scene.start;
  auto solved = solver.Poses().begin();
  for (auto& [idx, pose] : poses) pose = *solved++;
  EXPECT_NEAR(Cost(scene, poses), summary.final_cost, 1e-9 * summary.final_cost);
  for (auto& [idx, pose] : poses) {
    if (idx == 3) continue;
    const Rigid3 here = pose;
    for (int i = 0; i < 6; ++i) {
      for (const double step : {-0.01, 0.01}) {
        pose = here * PerturbLeft(step * Vector6d::Unit(i), Rigid3());
        EXPECT_GT(Cost(scene, poses), summary.final_cost);
      }
    }
    pose = here;
  }
}

TEST(GraphSolver, TheFirstPoseStaysAndAnEdgeWithoutWeightCountsForNothing) {
  GraphScene scene = MakeGraphScene(0.05);
  GraphSolver without(scene.edges, scene.start);
  std::ignore = without.Solve(Ones(scene), kMaxSteps);
  EXPECT_EQ(without.Poses()[0].Matrix(), scene.start.at(3).Matrix());
  std::vector<double> weights = Ones(scene);
  scene.edges.push_back({10, 101, Rigid3(), 1e-6 * Matrix6d::Identity(), false});
  weights.push_back(0);
  GraphSolver with(scene.edges, scene.start);
  std::ignore = with.Solve(weights, kMaxSteps);
  for (std::size_t i = 0; i < kNumNodes; ++i) {
    EXPECT_LT((with.Poses()[i].translation - without.Poses()[i].translation).norm(), 1e-4);
  }
}

TEST(GraphSolver, EdgesLoseAndRegainTheirWeight) {
  const GraphScene scene = MakeGraphScene(0.05);
  std::vector<double> chain_only = Ones(scene);
  std::fill(chain_only.begin() + kNumNodes - 1, chain_only.end(), 0);
  GraphScene chain = scene;
  chain.edges.resize(kNumNodes - 1);
  GraphSolver solver(scene.edges, scene.start);
  const auto expect_as_of = [&](const GraphScene& expected, const std::vector<double>& weights) {
    std::ignore = solver.Solve(weights, kMaxSteps);
    GraphSolver fresh(expected.edges, scene.start);
    std::ignore = fresh.Solve(Ones(expected), kMaxSteps);
    for (std::size_t i = 0; i < kNumNodes; ++i) {
      EXPECT_LT((solver.Poses()[i].translation - fresh.Poses()[i].translation).norm(), 1e-3);
    }
  };
  expect_as_of(scene, Ones(scene));
  expect_as_of(chain, chain_only);
  expect_as_of(scene, Ones(scene));
}

// Two laps, of which each place of the second is tied to the first. The odometry's heading drifts
// by a radian and more, so that the start is bent: moved one by one along the tangent, poses need
// many more steps.
TEST(GraphSolver, ALongWayThatIsBentIsStraightInFewSteps) {
  constexpr int kLap = 1000;
  const auto truth = [](int i) {
    const double angle = 2 * std::numbers::pi * (i % kLap) / kLap;
    return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                  {40 * std::sin(angle), -40 * std::cos(angle), 0}};
  };
  Random random(4);
  std::vector<PoseEdge> edges;
  std::map<int, Rigid3> start = {{0, truth(0)}};
  for (int i = 1; i < 2 * kLap; ++i) {
    Rigid3 b_from_a = truth(i).Inverse() * truth(i - 1);
    Vector6d noise = Noise(0.002, random);
    noise[2] += 0.001;  // of the heading
    b_from_a = PerturbLeft(noise, b_from_a);
    edges.push_back({i - 1, i, b_from_a, 1e-5 * Matrix6d::Identity(), false});
    start[i] = start[i - 1] * b_from_a.Inverse();
    if (i < kLap) continue;
    const Rigid3 loop = truth(i).Inverse() * truth(i - kLap);
    edges.push_back({i - kLap, i, loop, 1e-5 * Matrix6d::Identity(), false});
  }
  GraphSolver solver(edges, start);
  EXPECT_TRUE(solver.Solve(std::vector<double>(edges.size(), 1), 15).has_converged);
}

// One lap of 2.5 km whose odometry misses its start by a radian and by hundreds of metres, and the
// loops that close it: however a full step is applied, it goes too far.
TEST(GraphSolver, ALargeRingIsClosedInFewSteps) {
  constexpr int kLap = 5000;
  const auto truth = [](int i) {
    const double angle = 2 * std::numbers::pi * i / kLap;
    return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                  {400 * std::sin(angle), -400 * std::cos(angle), 0}};
  };
  Random random(4);
  std::vector<PoseEdge> edges;
  std::map<int, Rigid3> start = {{0, truth(0)}};
  for (int i = 1; i < kLap; ++i) {
    Vector6d noise = Noise(0.002, random);
    noise[2] += 0.0002 + 0.002 * std::sin(0.002 * i);  // of the heading
    const Rigid3 b_from_a = PerturbLeft(noise, truth(i).Inverse() * truth(i - 1));
    edges.push_back({i - 1, i, b_from_a, 1e-5 * Matrix6d::Identity(), false});
    start[i] = start[i - 1] * b_from_a.Inverse();
  }
  for (int i = 0; i < 10; ++i) {
    const Rigid3 loop = truth(kLap - 1 - i).Inverse() * truth(i);
    edges.push_back({i, kLap - 1 - i, loop, 1e-5 * Matrix6d::Identity(), false});
  }
  GraphSolver solver(edges, start);
  const GraphSummary summary = solver.Solve(std::vector<double>(edges.size(), 1), 30);
  EXPECT_TRUE(summary.has_converged);
  EXPECT_LT(summary.final_cost, 0.01 * summary.initial_cost);
}

// Where a loop that joins a part has lost its weight, nothing holds the part.
TEST(GraphSolver, APartThatNothingHoldsKeepsItsShape) {
  const GraphScene scene = MakeGraphScene(0);
  std::vector<PoseEdge> edges(scene.edges.begin(), scene.edges.begin() + kNumNodes - 1);
  std::vector<double> weights(edges.size(), 1);
  weights[20] = 0;
  GraphSolver solver(edges, scene.start);
  const GraphSummary summary = solver.Solve(weights, kMaxSteps);
  EXPECT_LT(summary.final_cost, 1e-9 * summary.initial_cost);
  const auto& poses = solver.Poses();
  const Rigid3 relative = poses[39].Inverse() * poses[21];
  const Rigid3 exact = scene.truth.at(7 * 39 + 3).Inverse() * scene.truth.at(7 * 21 + 3);
  EXPECT_LT((relative.translation - exact.translation).norm(), 1e-4);
}

// The full step from afar raises the cost.
TEST(GraphSolver, EachStepLowersTheCost) {
  GraphScene scene = MakeGraphScene(0.1);
  Random random(8);
  for (auto& [idx, pose] : scene.start) pose = RandomPose(random);
  GraphSolver solver(scene.edges, scene.start);
  double cost = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 5; ++i) {
    const GraphSummary summary = solver.Solve(Ones(scene), 1);
    EXPECT_EQ(summary.num_steps, 1);
    EXPECT_LT(summary.final_cost, summary.initial_cost);
    EXPECT_LE(summary.initial_cost, cost * (1 + 1e-12));  // the sum of gains rounds
    cost = summary.final_cost;
  }
}

TEST(GraphSolver, OnePoseIsSolved) {
  GraphSolver solver({}, {{4, Rigid3()}});
  EXPECT_EQ(solver.Solve({}, kMaxSteps).num_steps, 0);
  EXPECT_EQ(solver.Poses().size(), 1U);
}

TEST(GraphSolver, ACostThatIsNoNumberIsAnError) {
  GraphScene scene = MakeGraphScene(0);
  scene.start[10].translation.x() = std::nan("");
  GraphSolver solver(scene.edges, scene.start);
  NIGHTMAP_EXPECT_ERROR(DataError, solver.Solve(Ones(scene), kMaxSteps), "was not optimized");
}

}  // namespace nightmap::graph_solver_test
