// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/optimize_graph.h"

#include "pipeline/base/random.h"
#include "tests/failing_cholmod.h"
#include "tests/stages/graph/pose_graph/circle_scene.h"

namespace nightmap::optimize_graph_test {

PoseEdge ExactEdge(int a, int b) {
  return {a, b, TrueRelative(a, b), 1e-4 * Matrix6d::Identity(), false};
}

struct Scene {
  std::vector<GraphEdge> edges;
  std::map<int, Rigid3> poses;
};

// A circle whose odometry drifts, with exact loops and some that are wrong.
Scene MakeScene(int num_wrong_loops) {
  Scene scene;
  Random random(9);
  scene.poses[0] = TruePose(0);
  for (int i = 1; i < kNumFrames; ++i) {
    PoseEdge edge = ExactEdge(i - 1, i);
    edge.b_from_a.translation.x() += 0.01 * random.Gaussian();
    edge.b_from_a.translation.z() += 0.01 * random.Gaussian();
    scene.poses[i] = scene.poses[i - 1] * edge.b_from_a.Inverse();
    scene.edges.push_back({edge, false});
  }
  for (int k = 0; k < 5; ++k) scene.edges.push_back({ExactEdge(k, kNumFrames - 5 + k), true});
  for (int k = 0; k < num_wrong_loops; ++k) {
    PoseEdge wrong = ExactEdge(2 * k, 20 + k);
    wrong.b_from_a.translation += Eigen::Vector3d(1, -2, 0.5);
    scene.edges.push_back({wrong, true});
  }
  return scene;
}

void Optimize(std::vector<GraphEdge>* edges, std::map<int, Rigid3>* poses) {
  const GraduationSummary summary = OptimizeGraph(6, edges, poses);
  EXPECT_TRUE(summary.last.has_converged);
  EXPECT_LE(summary.last.final_cost, summary.last.initial_cost);
  EXPECT_GT(summary.num_rounds, 1);
}

double WorstError_m(const Scene& scene) {
  double worst = 0;
  for (const auto& [i, pose] : scene.poses) {
    worst = std::max(worst, (pose.translation - TruePose(i).translation).norm());
  }
  return worst;
}

TEST(OptimizeGraph, LoopsReduceDrift) {
  Scene scene = MakeScene(0);
  const double before_m = WorstError_m(scene);
  Optimize(&scene.edges, &scene.poses);
  EXPECT_LT(WorstError_m(scene), 0.8 * before_m);
  EXPECT_EQ(scene.poses[0].Matrix(), TruePose(0).Matrix());
}

TEST(OptimizeGraph, WrongLoopsAreRefusedAndRightOnesKept) {
  Scene clean = MakeScene(0);
  Optimize(&clean.edges, &clean.poses);
  Scene scene = MakeScene(4);
  Optimize(&scene.edges, &scene.poses);
  for (std::size_t i = 0; i < scene.edges.size(); ++i) {
    const bool is_wrong = i >= clean.edges.size();
    EXPECT_EQ(scene.edges[i].weight > 0.5, !is_wrong) << i;
  }
  EXPECT_NEAR(WorstError_m(scene), WorstError_m(clean), 1e-4);
}

TEST(OptimizeGraph, ALoopFromFarAwayTakesFewRounds) {
  Scene scene = MakeScene(1);
  scene.edges.back().edge.b_from_a.translation *= 1e4;
  EXPECT_LE(OptimizeGraph(6, &scene.edges, &scene.poses).num_rounds, 15);
  EXPECT_EQ(scene.edges.back().weight, 0);
}

TEST(OptimizeGraph, MovingTheWholeGraphChangesNothing) {
  Scene scene = MakeScene(2);
  Scene moved = scene;
  const Rigid3 motion{Eigen::Quaterniond(Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX())),
                      {4, 5, 6}};
  for (auto& [i, pose] : moved.poses) pose = motion * pose;
  Optimize(&scene.edges, &scene.poses);
  Optimize(&moved.edges, &moved.poses);
  for (const auto& [i, pose] : scene.poses) {
    EXPECT_LT((motion * pose.translation - moved.poses[i].translation).norm(), 1e-4);
  }
}

TEST(OptimizeGraph, WithoutMemoryItIsAnError) {
  Scene scene = MakeScene(0);
  const FailingCholmod without_memory(10'000);
  NIGHTMAP_EXPECT_ERROR(
      DataError, OptimizeGraph(6, &scene.edges, &scene.poses), "does not fit into memory");
}

}  // namespace nightmap::optimize_graph_test
