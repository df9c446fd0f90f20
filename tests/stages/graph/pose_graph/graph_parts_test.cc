// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/graph_parts.h"

#include <gtest/gtest.h>

namespace nightmap::graph_parts_test {

GraphEdge Edge(int a, int b, bool is_bridge, bool is_loop = false, double weight = 1) {
  GraphEdge edge{{a, b, Rigid3(), Matrix6d::Identity(), is_bridge}, is_loop};
  edge.weight = weight;
  return edge;
}

using Runs = std::vector<std::pair<int, int>>;

// Keyframes 0, 3, 6 and 9 of 12 frames; nobody knows the way from 3 to 6.
const std::set<int> kKeyframes = {0, 3, 6, 9};
const std::vector<GraphEdge> kOdometry = {Edge(0, 3, false), Edge(3, 6, true), Edge(6, 9, false)};

TEST(GraphParts, BridgesHoldNothingTogether) {
  const auto parts = FindParts(kOdometry, kKeyframes, 12);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].runs, (Runs{{0, 5}}));
  EXPECT_EQ(parts[1].runs, (Runs{{6, 11}}));
  EXPECT_EQ(parts[0].num_frames, 6);
}

TEST(GraphParts, LoopsJoinOnlyWhenBelieved) {
  for (const double weight : {0.0, 1.0}) {
    auto edges = kOdometry;
    edges.push_back(Edge(0, 9, false, true, weight));
    EXPECT_EQ(FindParts(edges, kKeyframes, 12).size(), weight > 0 ? 1U : 2U);
  }
}

TEST(GraphParts, LargestFirstInRuns) {
  const std::vector<GraphEdge> edges = {
      Edge(0, 3, true), Edge(3, 6, false), Edge(6, 9, true), Edge(3, 9, false, true)};
  const auto parts = FindParts(edges, kKeyframes, 12);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].runs, (Runs{{3, 11}}));
  EXPECT_EQ(parts[1].runs, (Runs{{0, 2}}));
  const auto apart = FindParts({Edge(0, 9, false, true)}, kKeyframes, 12);
  ASSERT_EQ(apart.size(), 3U);
  EXPECT_EQ(apart[0].runs, (Runs{{0, 2}, {9, 11}}));
}

TEST(GraphParts, OnlyABelievedLoopFromTheFirstToTheLastReturns) {
  std::set<int> keyframes;
  for (int i = 0; i < 10; ++i) keyframes.insert(2 * i);
  EXPECT_TRUE(ReturnsToStart({Edge(0, 18, false, true)}, keyframes));
  EXPECT_FALSE(ReturnsToStart({Edge(0, 18, false, true, 0)}, keyframes));
  EXPECT_FALSE(ReturnsToStart({Edge(0, 18, false, false)}, keyframes));
  EXPECT_FALSE(ReturnsToStart({Edge(2, 18, false, true)}, keyframes));
  EXPECT_FALSE(ReturnsToStart({Edge(0, 16, false, true)}, keyframes));
}

}  // namespace nightmap::graph_parts_test
