// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/pose_graph.h"

#include "stages/graph/pose_graph/pose_graph_output.h"
#include "tests/stages/graph/pose_graph/circle_scene.h"

namespace nightmap::pose_graph_test {

TEST(PoseGraph, LoopsCorrectTheDriftOfEveryFrame) {
  EXPECT_LT(WorstError_m(Optimize(MakeInput())), 0.7 * WorstError_m(Optimize(MakeInput(0))));
}

TEST(PoseGraph, EveryFrameHasAPoseAndEveryCandidateAVerdict) {
  PoseGraphInput input = MakeInput();
  input.loops[0].status = PairStatus::kPoorSpread;
  input.loops[1].b_from_a.translation += Eigen::Vector3d(0, 0.6, 0);  // wrong, as drift might be
  input.loops.push_back(input.loops[2]);
  input.loops.back().b_from_a.translation += Eigen::Vector3d(3, 0, 1);  // wrong, as no drift is
  input.loops.push_back(input.loops[2]);
  input.loops.back().frame_a = 24;  // its nearest keyframe is that of frame_b
  input.loops.back().frame_b = 25;
  const PoseGraphResult result = Optimize(input);
  EXPECT_EQ(result.graph_from_camera.size(), static_cast<std::size_t>(kNumFrames));
  ASSERT_EQ(result.loops.size(), 6U);
  EXPECT_EQ(result.loops[0].reason, PairStatusText(PairStatus::kPoorSpread));
  EXPECT_THAT(result.loops[1].reason, testing::HasSubstr("contradicts"));
  EXPECT_TRUE(result.loops[2].is_accepted);
  EXPECT_TRUE(result.loops[3].is_accepted);
  EXPECT_THAT(result.loops[4].reason, testing::HasSubstr("can have drifted"));
  EXPECT_THAT(result.loops[5].reason, testing::HasSubstr("one keyframe"));
  const std::string csv = LoopsToCsv(result.loops);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 7);
  EXPECT_EQ(result.graph.is_loop_accepted,
            (std::vector<bool>{false, false, true, true, false, false}));
}

TEST(PoseGraph, WithoutLoopsTheGraphIsTheOdometry) {
  const PoseGraphInput input = MakeInput(0);
  const PoseGraphResult result = Optimize(input);
  EXPECT_THAT(Summarize(input, result).at("loops").get<std::string>(),
              testing::HasSubstr("no loop found"));
  for (const PoseEdge& edge : result.edges) EXPECT_LT(edge.frame_a, edge.frame_b);
}

TEST(PoseGraph, LoopsJoinWhatTheTrackingLost) {
  const double whole_m = WorstError_m(Optimize(MakeInput()));
  const PoseGraphResult result = Optimize(MakeBrokenInput());
  EXPECT_LT(WorstError_m(result), whole_m + 0.1);
  ASSERT_EQ(result.parts.size(), 1U);
  EXPECT_EQ(result.parts[0].num_frames, kNumFrames);
  EXPECT_TRUE(result.returns_to_start);
  EXPECT_EQ(result.graph.replaced_bridges, std::set<int>{12});
}

TEST(PoseGraph, PartsThatNoLoopJoinsAreReported) {
  const PoseGraphInput input = MakeBrokenInput(0);
  const PoseGraphResult result = Optimize(input);
  EXPECT_FALSE(result.returns_to_start);
  EXPECT_TRUE(result.graph.replaced_bridges.empty());
  ASSERT_EQ(result.parts.size(), 2U);
  using Runs = std::vector<std::pair<int, int>>;
  EXPECT_EQ(result.parts[0].runs, (Runs{{12, kNumFrames - 1}}));
  EXPECT_EQ(result.parts[1].runs, (Runs{{0, 11}}));
  EXPECT_EQ(Summarize(input, result).at("parts").size(), 2U);
  EXPECT_EQ(result.graph_from_camera.size(), static_cast<std::size_t>(kNumFrames));
}

TEST(PoseGraph, RefusesToCallPiecesAMap) {
  const PoseGraphInput input = MakeBrokenInput(0);  // the largest part has 3/4 of the frames
  PoseGraphOptions options;
  options.min_connected_ratio = 0.7;
  EXPECT_EQ(Optimize(input, options).parts.size(), 2U);
  options.min_connected_ratio = 0.8;
  NIGHTMAP_EXPECT_ERROR(ThresholdError, Optimize(input, options), "36 of 48 frames");
}

TEST(PoseGraph, RefusesOdometryOfOtherFrames) {
  PoseGraphInput input = MakeInput();
  input.odometry.pop_back();
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "odometry");
  input = MakeInput();
  input.loops[0].frame_b = kNumFrames;
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "loop");
}

TEST(PoseGraph, RefusesOdometryThatDoesNotFitTogether) {
  const auto expect = [](const auto& damage, const std::string& message) {
    PoseGraphInput input = MakeInput();
    damage(input.odometry);
    NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), message, "odometry[");
  };
  using Shards = std::vector<OdometryShard>;
  expect(
      [](Shards& shards) {
        shards.push_back({{}, {shards[0].edges[0]}, {}});
      },
      "odometry[2]: has edge 0-3 and no frames");
  expect(
      [](Shards& shards) {
        for (OdometryShard& shard : shards) {
          for (OdometryFrame& frame : shard.frames) frame.is_keyframe = false;
        }
      },
      "frame 0, the first, is not a keyframe");
  expect([](Shards& shards) { shards[0].frames[0].is_keyframe = false; },
         "frame 0, the first, is not a keyframe");
  expect([](Shards& shards) { shards[0].frames[6].is_keyframe = false; },
         "edge 3-6 ends at frame 6, which is not a keyframe");
  expect([](Shards& shards) { shards[1].edges.back().frame_b = kNumFrames; },
         "ends at frame 48, which is not a keyframe");
  expect([](Shards& shards) { shards[1].edges[0].frame_b = 21; },
         "edge 23-21 does not end in its shard, frames 24 to 47");
  expect([](Shards& shards) { shards[1].edges.erase(shards[1].edges.begin()); },
         "no edge joins the shard of frame 24 to the one before");
}

}  // namespace nightmap::pose_graph_test
