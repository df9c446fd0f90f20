// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/fill_bridges.h"

#include <gtest/gtest.h>

#include "tests/stages/graph/pose_graph/circle_scene.h"

namespace nightmap::fill_bridges_test {

// An exact chain, every third frame a keyframe, that goes on somewhere else after each bridge.
OdometryChain BrokenChain(const std::set<int>& bridges) {
  OdometryChain chain;
  Rigid3 graph_from_truth;
  for (int i = 0; i < kNumFrames; ++i) {
    if (bridges.contains(i)) graph_from_truth = Elsewhere() * graph_from_truth;
    chain.graph_from_camera.push_back(graph_from_truth * TruePose(i));
    if (i % 3 == 0) chain.keyframes.insert(i);
    if (i == 0 || i % 3 != 0) continue;
    const Rigid3 b_from_a = chain.At(i).Inverse() * chain.At(i - 3);
    chain.edges.push_back({i - 3, i, b_from_a, Matrix6d::Identity(), bridges.contains(i)});
  }
  chain.after_bridge = bridges;
  return chain;
}

SensorGraph Wheels(int first, int last) {
  SensorGraph wheels{"wheels", {}, {}, {}};
  for (int i = first; i < last; ++i) {
    wheels.odometry.push_back({i, i + 1, TrueRelative(i, i + 1), Matrix6d::Identity(), false});
  }
  return wheels;
}

TEST(FillBridges, FramesMoveWithAllBridgesBeforeThem) {
  OdometryChain chain = BrokenChain({9, 12, 30, 45});
  // The second sensor fills what the first left, before and after it.
  const std::vector<SensorGraph> sensors = {Wheels(10, 36), Wheels(0, kNumFrames - 1)};
  const FilledBridges filled = FillBridges({}, sensors, &chain);
  EXPECT_EQ(filled, (FilledBridges{{9, 1}, {12, 0}, {30, 0}, {45, 1}}));
  EXPECT_TRUE(chain.after_bridge.empty());
  for (int i = 0; i < kNumFrames; ++i) {
    EXPECT_LT((chain.At(i).translation - TruePose(i).translation).norm(), 1e-9) << i;
  }
  for (const PoseEdge& edge : chain.edges) {
    EXPECT_FALSE(edge.is_bridge);
    const Rigid3 b_from_a = TrueRelative(edge.frame_a, edge.frame_b);
    EXPECT_LT((edge.b_from_a.translation - b_from_a.translation).norm(), 1e-9);
  }
}

}  // namespace nightmap::fill_bridges_test
