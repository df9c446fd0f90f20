// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/join_runs.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stages/graph/pose_graph/drift_gate.h"
#include "tests/stages/graph/pose_graph/noisy_path.h"

namespace nightmap::join_runs_test {

constexpr double kMaxDrift = 10;

// Tracking is lost before frames 30 and 60, and where it goes on nobody knows.
std::vector<PoseEdge> BrokenDrive() {
  std::vector<PoseEdge> edges = Drive(90, 3);
  for (const std::size_t lost : {29U, 59U}) {
    edges[lost].is_bridge = true;
    edges[lost].b_from_a.translation += Eigen::Vector3d(20, -7, 3);
    edges[lost].covariance = 1e4 * Matrix6d::Identity();
  }
  return edges;
}

PoseEdge WrongLoop(int a, int b, const Eigen::Vector3d& offset) {
  PoseEdge loop = TrueLoop(a, b);
  loop.b_from_a.translation += offset;
  return loop;
}

double Error_m(const std::vector<PoseEdge>& tree, int a, int b) {
  const auto poses = DriftGate(tree).Poses();
  return (poses.at(b).Inverse() * poses.at(a) * TrueLoop(a, b).b_from_a.Inverse())
      .translation.norm();
}

TEST(JoinRuns, PutsRunsWhereMostLoopsWantThem) {
  std::vector<PoseEdge> loops;
  for (const int i : {0, 5, 10}) {
    loops.push_back(WrongLoop(i, 40 + i, {5, 0, 0}));  // agree with each other, but are fewer
  }
  for (const int i : {0, 4, 8, 12}) loops.push_back(TrueLoop(i, 35 + i));
  for (const int i : {30, 33, 36}) loops.push_back(TrueLoop(i, 40 + i));
  const auto tree = JoinRuns(BrokenDrive(), loops, kMaxDrift);
  EXPECT_EQ(tree.size(), 89U);
  EXPECT_EQ(std::ranges::count_if(tree, &PoseEdge::is_bridge), 0);
  EXPECT_LT(Error_m(tree, 3, 45), 1.5);  // the drift of some 40 steps
  EXPECT_LT(Error_m(tree, 3, 80), 3);
}

TEST(JoinRuns, TwoLoopsAreNotEnough) {
  const auto odometry = BrokenDrive();
  const auto tree = JoinRuns(odometry, {TrueLoop(0, 40), TrueLoop(5, 45)}, kMaxDrift);
  EXPECT_EQ(std::ranges::count_if(tree, &PoseEdge::is_bridge), 2);
  const auto poses = DriftGate(tree).Poses();
  const auto by_odometry = DriftGate(odometry).Poses();
  for (const auto& [idx, pose] : by_odometry) {
    EXPECT_EQ(pose.translation, poses.at(idx).translation);
  }
}

// The run in the middle has no loop; it stays where its bridge puts it while the last one is
// joined.
TEST(JoinRuns, ARunWithoutLoopsHangsOnItsBridge) {
  const auto tree =
      JoinRuns(BrokenDrive(), {TrueLoop(0, 70), TrueLoop(5, 75), TrueLoop(10, 80)}, kMaxDrift);
  EXPECT_EQ(std::ranges::count_if(tree, &PoseEdge::is_bridge), 1);
  EXPECT_LT(Error_m(tree, 3, 80), 1.5);
  EXPECT_GT(Error_m(tree, 3, 45), 10);
}

TEST(JoinRuns, WithoutBridgesNothingChanges) {
  const auto odometry = Drive(20, 1);
  const auto tree = JoinRuns(odometry, {TrueLoop(0, 19)}, kMaxDrift);
  ASSERT_EQ(tree.size(), odometry.size());
  for (std::size_t i = 0; i < tree.size(); ++i) EXPECT_EQ(tree[i].frame_b, odometry[i].frame_b);
}

}  // namespace nightmap::join_runs_test
