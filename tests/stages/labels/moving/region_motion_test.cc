// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/region_motion.h"

#include <gtest/gtest.h>

namespace nightmap::region_motion_test {

using Side = std::vector<RegionScore>;

FrameRegions OneRegion(const Side& before, const Side& after) {
  FrameRegions frame;
  frame.regions.num = 1;
  frame.scores = {{before, after}};
  return frame;
}

// Whether the region of each of these frames, which are one thing, moves.
std::vector<bool> Decide(const std::vector<FrameRegions>& frames) {
  std::vector<const FrameRegions*> pointers;
  for (const FrameRegions& frame : frames) pointers.push_back(&frame);
  const std::vector<std::vector<int>> same(frames.size() - 1, {1});
  std::vector<bool> decided;
  for (const auto& moves : DecideRegions(pointers, same)) decided.push_back(moves.at(0));
  return decided;
}

TEST(RegionMotionTest, WhatStaysSinceOrUntilTheNearestFrameDoesNotMove) {
  EXPECT_EQ(Decide({OneRegion({-0.9, -0.9}, {-0.9, -0.9})}), std::vector{false});
  EXPECT_EQ(Decide({OneRegion({0.9, 0.9, 0.9}, {-0.9, -0.9, 0.9})}), std::vector{false});
  EXPECT_EQ(Decide({OneRegion({-0.9, -0.9, 0.9}, {0.9, 0.9, 0.9})}), std::vector{false});
  EXPECT_EQ(Decide({OneRegion({0.9}, {-0.9})}), std::vector{false});
  EXPECT_EQ(Decide({OneRegion({0.3, -0.9}, {0.3, -0.9})}), std::vector{true});
}

TEST(RegionMotionTest, FramesOfBothSidesDecideTogether) {
  EXPECT_EQ(Decide({OneRegion({-0.2, -0.2}, {-0.2, 0.9})}), std::vector{false});
  EXPECT_EQ(Decide({OneRegion({-0.2, 0.9}, {-0.2, 0.9})}), std::vector{true});
  EXPECT_EQ(Decide({OneRegion({-0.2, 0.9}, {-0.2, -0.2})}), std::vector{false});
  EXPECT_EQ(Decide({OneRegion({-0.2, std::nullopt}, {-0.2, 0.9})}), std::vector{true});
  EXPECT_EQ(Decide({OneRegion({}, {0.9})}), std::vector{true});
}

TEST(RegionMotionTest, WithoutAnyWordLabelsDecide) {
  EXPECT_EQ(Decide({OneRegion({}, {})}), std::vector{true});
  EXPECT_EQ(Decide({OneRegion({std::nullopt}, {std::nullopt})}), std::vector{true});
}

TEST(RegionMotionTest, DoubtFollowsTheNeighbourInTimeBothWays) {
  const FrameRegions moves = OneRegion({0.9}, {0.9});
  const FrameRegions doubt = OneRegion({-0.2}, {-0.2});
  const FrameRegions stays = OneRegion({-0.9}, {-0.9});
  EXPECT_EQ(Decide({doubt, doubt, moves, doubt, stays, doubt}),
            (std::vector{true, true, true, true, false, false}));
}

TEST(RegionMotionTest, ScoresAreSharesOfTheVotes) {
  const DepthImage depth{4, 1, 1, {1, 1, 2, 2}};
  FrameRegions frame;
  frame.regions = {{4, 1, 1, {1, 1, 2, 0}}, 2};
  frame.scores.resize(2);
  Evidence by_depth(depth), by_flow(depth);
  by_depth.gone.pixels = {2, 0, 0, 5};
  by_depth.stays.pixels = {0, 1.5, 0, 0};
  by_flow.gone.pixels = {1, 0, 0, 0};
  by_flow.stays.pixels = {0, 0.75, 0, 0};
  AddScores(0.8, by_depth, by_flow, true, 2, &frame);
  ASSERT_EQ(frame.scores[0].after.size(), 2U);
  EXPECT_EQ(frame.scores[0].after[0], frame.scores[0].after[1]);
  EXPECT_NEAR(frame.scores[0].after[0].value(), 0.5, 1e-9);  // (3 - 1) / (3 + 1)
  EXPECT_FALSE(frame.scores[1].after[0]);
  EXPECT_TRUE(frame.scores[0].before.empty());
}

// A camera without motion before a picture of four pixels, whose regions are given by pixel.
std::vector<int> SameOf(const std::vector<std::int32_t>& before,
                        const std::vector<std::int32_t>& after) {
  RgbdCamera camera;
  camera.color = Camera{8, 2, 8, 8, 3.5, 0.5};
  const SmallCamera small = Shrink(camera);
  SmallFrame frame;
  frame.depth = {small.depth.width, small.depth.height, 1, {1, 1, 1, 1}};
  const auto regions = [&](const std::vector<std::int32_t>& of_pixel) {
    return FrameRegions{
        {{small.depth.width, small.depth.height, 1, of_pixel}, *std::ranges::max_element(of_pixel)},
        {}};
  };
  return SameRegions(small, frame, regions(before), regions(after), Rigid3{});
}

TEST(RegionMotionTest, AScrapIsNotTheWhole) {
  EXPECT_EQ(SameOf({1, 1, 1, 0}, {1, 1, 1, 0}), std::vector{1});
  EXPECT_EQ(SameOf({1, 2, 2, 2}, {1, 1, 1, 1}), (std::vector{0, 1}));
  EXPECT_EQ(SameOf({1, 1, 1, 1}, {1, 0, 0, 0}), std::vector{0});
}

}  // namespace nightmap::region_motion_test
