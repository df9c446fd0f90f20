// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/pose_graph.h"

#include "pipeline/base/error.h"
#include "stages/pose_graph/pose_graph_output.h"
#include "tests/stages/pose_graph/circle_scene.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

TEST(PoseGraph, LoopsCorrectTheDriftOfEveryFrame) {
  PoseGraphInput input = MakeInput();
  const double closed_m = WorstError_m(Optimize(input));
  input.loops.clear();
  const double open_m = WorstError_m(Optimize(input));
  EXPECT_LT(closed_m, 0.7 * open_m);
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
}

// All keyframes see the same points, so few keyframes are needed.
TEST(PoseGraph, DroppedKeyframesKeepTheirPosesAndTheEdgesGoPastThem) {
  PoseGraphInput input = MakeInput();
  SeeTheSamePoints(&input);
  PoseGraphOptions options;
  options.bundle_adjustment = false;
  Progress progress("pose_graph", false);
  options.max_seen_ratio = 1;
  const PoseGraphResult all = RunPoseGraph(options, input, 1, progress);
  options.max_seen_ratio = 0.9;
  const PoseGraphResult few = RunPoseGraph(options, input, 1, progress);
  EXPECT_EQ(all.num_culled, 0);
  EXPECT_GT(few.num_culled, 5);
  EXPECT_EQ(few.graph.vertices.size() + static_cast<std::size_t>(few.num_culled),
            all.graph.vertices.size());
  for (std::size_t i = 0; i < all.graph_from_camera.size(); ++i) {
    EXPECT_LT((few.graph_from_camera[i].translation - all.graph_from_camera[i].translation).norm(),
              0.05);
  }
  std::size_t num_chained = 0;
  for (const PoseEdge& edge : few.graph.edges) {
    if (num_chained + 1 == few.graph.vertices.size()) break;
    EXPECT_EQ(edge.frame_a, few.graph.vertices[num_chained].frame_idx);
    EXPECT_EQ(edge.frame_b, few.graph.vertices[num_chained + 1].frame_idx);
    ++num_chained;
  }
}

TEST(PoseGraph, IsTheSameAtAnyNumberOfThreads) {
  const PoseGraphInput input = MakeInput();
  const PoseGraphResult one = Optimize(input, 1);
  const PoseGraphResult four = Optimize(input, 4);
  EXPECT_EQ(TrajectoryText(input, one, false), TrajectoryText(input, four, false));
}

TEST(PoseGraph, WithoutLoopsTheGraphIsTheOdometry) {
  PoseGraphInput input = MakeInput();
  input.loops.clear();
  const PoseGraphResult result = Optimize(input);
  EXPECT_THAT(Summarize({}, input, result).at("loops").get<std::string>(),
              testing::HasSubstr("no loop found"));
  for (const PoseEdge& edge : result.graph.edges) EXPECT_LT(edge.frame_a, edge.frame_b);
}

TEST(PoseGraph, LoopsJoinWhatTheTrackingLost) {
  const double whole_m = WorstError_m(Optimize(MakeInput()));
  const PoseGraphResult result = Optimize(MakeBrokenInput());
  EXPECT_LT(WorstError_m(result), whole_m + 0.1);
  ASSERT_EQ(result.parts.size(), 1U);
  EXPECT_EQ(result.parts[0].num_frames, kNumFrames);
  EXPECT_TRUE(result.returns_to_start);
}

TEST(PoseGraph, PartsThatNoLoopJoinsAreReported) {
  PoseGraphInput input = MakeBrokenInput();
  input.loops.clear();
  const PoseGraphResult result = Optimize(input);
  EXPECT_FALSE(result.returns_to_start);
  ASSERT_EQ(result.parts.size(), 2U);
  using Runs = std::vector<std::pair<int, int>>;
  EXPECT_EQ(result.parts[0].runs, (Runs{{12, kNumFrames - 1}}));
  EXPECT_EQ(result.parts[1].runs, (Runs{{0, 11}}));
  EXPECT_EQ(Summarize({}, input, result).at("parts").size(), 2U);
  EXPECT_EQ(result.graph_from_camera.size(), static_cast<std::size_t>(kNumFrames));
}

TEST(PoseGraph, RefusesOdometryOfOtherFrames) {
  PoseGraphInput input = MakeInput();
  input.odometry.pop_back();
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "odometry");
  input = MakeInput();
  input.loops[0].frame_b = kNumFrames;
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "loop");
  input = MakeInput();
  input.features.frames[3].frame_idx = 4;
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "not of the listed frames");
}

TEST(PoseGraph, RefusesOdometryThatDoesNotFitTogether) {
  const auto expect = [](const auto& damage, const std::string& message) {
    PoseGraphInput input = MakeInput();
    damage(input.odometry);
    NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), message);
    NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "odometry[");
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
  // No frame of MakeInput has a feature.
  for (const Sighting& damaged : {Sighting{0, 0}, Sighting{kNumFrames, 0}}) {
    expect([&](Shards& shards) { shards[1].tracks = {{damaged}}; },
           "which the 48 frames do not have");
  }
  expect([](Shards& shards) { shards[1].edges.erase(shards[1].edges.begin()); },
         "no edge joins the shard of frame 24 to the one before");
}

TEST(PoseGraph, RefusesTracksAndLoopsOfOtherFeatures) {
  PoseGraphInput input = MakeInput();
  input.odometry[1].tracks = {{{30, 7}}};
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "odometry[1]: a track has");
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "feature 7 of frame 30");
  input = MakeInput();
  input.odometry[1].tracks = {{{kNumFrames, 0}}};
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "feature 0 of frame 48");
  input = MakeInput();
  input.loops[0].inliers = {{3, 4}};
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "loops: loop ");
  NIGHTMAP_EXPECT_ERROR(DataError, Optimize(input), "matches features 3 and 4");
}

}  // namespace
}  // namespace nightmap
