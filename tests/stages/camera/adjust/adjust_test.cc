// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/adjust.h"

#include "pipeline/graph/frame_poses.h"
#include "stages/camera/adjust/adjust_output.h"
#include "tests/landmark_scene.h"
#include "tests/stages/graph/pose_graph/circle_scene.h"

namespace nightmap::adjust_test {

// An input whose features and odometry are in memory.
struct Whole : AdjustInput {
  FeaturesShard all_features;
  std::vector<OdometryShard> all_odometry;
  std::vector<FramePair> all_loops;

  AdjustInput Input() const {
    AdjustInput input = *this;
    input.features = SiteFeatures(all_features);
    input.num_shards = all_odometry.size();
    input.loops = [this] { return all_loops; };
    input.odometry = [this](std::size_t shard) { return all_odometry.at(shard); };
    return input;
  }
};

// Closes the loops of `closed`. Its frames have no features, so that adjustment adds nothing.
Whole After(const PoseGraphInput& closed) {
  Whole input;
  input.frames = closed.frames;
  input.all_odometry = closed.odometry;
  input.all_loops.assign(closed.loops.begin(), closed.loops.end());
  input.cameras = {RgbdCamera{}};
  input.cameras[0].color = Camera{64, 48, 50, 50, 32, 24};
  for (const FrameRecord& frame : closed.frames) {
    input.all_features.frames.emplace_back().frame_idx = frame.frame_idx;
  }
  input.graph = Optimize(closed).graph;
  return input;
}

// Every keyframe sees the same 50 points, without depth, so that adjustment adds nothing.
void SeeTheSamePoints(Whole* input) {
  for (FrameFeatures& frame : input->all_features.frames) {
    frame.keypoints_px = frame.raw_keypoints_px = std::vector<Eigen::Vector2f>(50, {1, 2});
    frame.scales_px.assign(50, 5);
    frame.depths_m.assign(50, 0);
    frame.descriptors.assign(std::size_t{50} * 128, 0);
  }
  for (OdometryShard& shard : input->all_odometry) {
    shard.tracks.resize(50);
    for (const OdometryFrame& frame : shard.frames) {
      if (!frame.is_keyframe) continue;
      for (int i = 0; i < 50; ++i) {
        shard.tracks[static_cast<std::size_t>(i)].push_back({frame.frame_idx, i});
      }
    }
  }
  for (FramePair& loop : input->all_loops) {
    for (int i = 0; i < 50; ++i) loop.inliers.push_back({i, i});
  }
}

AdjustResult Adjust(const Whole& input, const AdjustOptions& options = {}, int num_threads = 1) {
  return RunAdjust(options, input.Input(), NoProgress(), num_threads);
}

TEST(Adjust, WithoutPointsThePosesAreThoseOfTheGraph) {
  for (const PoseGraphInput& closed : {MakeInput(), MakeBrokenInput()}) {
    const AdjustResult result = Adjust(After(closed));
    const PoseGraphResult graph = Optimize(closed);
    ASSERT_EQ(result.graph_from_camera.size(), graph.graph_from_camera.size());
    for (std::size_t i = 0; i < result.graph_from_camera.size(); ++i) {
      EXPECT_TRUE(result.graph_from_camera[i].Matrix().isApprox(graph.graph_from_camera[i].Matrix(),
                                                                1e-12));
    }
    EXPECT_EQ(result.keyframes, graph.graph.chain.keyframes);
    ASSERT_EQ(result.graph.edges.size(), graph.edges.size());
    EXPECT_EQ(result.num_bundle_observations, 0);
  }
}

TEST(Adjust, WithoutLoopsThereAreThePosesOfTheOdometry) {
  const AdjustResult result = Adjust(After(MakeInput(0)));
  EXPECT_EQ(result.graph_from_camera.size(), static_cast<std::size_t>(kNumFrames));
  EXPECT_EQ(result.graph.edges.size() + 1, result.graph.vertices.size());
}

// All keyframes see the same points, so few keyframes are needed.
TEST(Adjust, DroppedKeyframesKeepTheirPosesAndTheEdgesGoPastThem) {
  Whole input = After(MakeInput());
  SeeTheSamePoints(&input);
  const AdjustResult all = Adjust(input, {.max_seen_ratio = 1});
  const AdjustResult few = Adjust(input, {.max_seen_ratio = 0.9});
  EXPECT_EQ(all.num_culled, 0);
  EXPECT_GT(few.num_culled, 5);
  EXPECT_EQ(few.graph.vertices.size() + static_cast<std::size_t>(few.num_culled),
            all.graph.vertices.size());
  EXPECT_EQ(few.keyframes.size(), few.graph.vertices.size());
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

TEST(Adjust, EdgesOfSensorsMoveToTheKeyframesThatStay) {
  PoseGraphInput closed = MakeInput();
  closed.edges = {{"wheels", {}}};
  for (int i = 0; i + 1 < kNumFrames; ++i) {
    closed.edges[0].edges.push_back(MakeEdge(EdgeKind::kOdometry, i, i + 1));
  }
  closed.edges[0].edges.push_back(MakeEdge(EdgeKind::kLoop, 1, kNumFrames - 1));
  closed.edges[0].edges.push_back(Survey({9}).edges[0]);
  const std::size_t num_of_camera = Adjust(After(MakeInput())).graph.edges.size();
  Whole input = After(closed);
  const std::size_t num_of_both = Adjust(input).graph.edges.size();
  EXPECT_GT(num_of_both, num_of_camera + 10);
  SeeTheSamePoints(&input);
  const AdjustResult result = Adjust(input);
  EXPECT_GT(result.num_culled, 5);
  EXPECT_LT(result.graph.edges.size(), num_of_both);
  for (const PoseEdge& edge : result.graph.edges) {
    EXPECT_TRUE(result.keyframes.contains(edge.frame_a) && result.keyframes.contains(edge.frame_b));
  }
}

TEST(Adjust, KeyframesBesideABridgeStay) {
  Whole input = After(MakeBrokenInput(0));
  SeeTheSamePoints(&input);
  const AdjustResult result = Adjust(input);
  EXPECT_GT(result.num_culled, 5);
  EXPECT_TRUE(result.keyframes.contains(9) && result.keyframes.contains(12));
}

TEST(Adjust, IsTheSameAtAnyNumberOfThreads) {
  Whole input = After(MakeBrokenInput());
  SeeTheSamePoints(&input);
  const AdjustResult one = Adjust(input, {}, 1), four = Adjust(input, {}, 4);
  EXPECT_EQ(TrajectoryText(input.frames, one.graph_from_camera),
            TrajectoryText(input.frames, four.graph_from_camera));
  EXPECT_EQ(PoseGraphToG2o(one.graph), PoseGraphToG2o(four.graph));
  EXPECT_EQ(Summarize({}, input, one), Summarize({}, input, four));
}

TEST(Adjust, RefusesArtifactsOfOtherRuns) {
  const auto expect = [](const auto& damage, const std::string& message) {
    Whole input = After(MakeInput());
    damage(input);
    NIGHTMAP_EXPECT_ERROR(DataError, Adjust(input), message);
  };
  expect([](Whole& input) { input.all_features.frames[3].frame_idx = 4; },
         "not of the listed frames");
  expect([](Whole& input) { input.frames.pop_back(); },
         "48 frames are in the graph, the lists have 47, 48 of them with features");
  expect([](Whole& input) { input.all_loops.pop_back(); },
         "the graph judges 4 loops, the list has 3");
  expect([](Whole& input) { input.all_loops[0].frame_b = kNumFrames; },
         "is not between frames of this site");
  // No frame of the circle has a feature.
  expect(
      [](Whole& input) {
        input.all_odometry[1].tracks = {{{30, 7}}};
      },
      "odometry[1]: a track has feature 7 of frame 30");
  expect(
      [](Whole& input) {
        input.all_odometry[1].tracks = {{{kNumFrames, 0}}};
      },
      "feature 0 of frame 48, which the 48 frames do not have");
  expect([](Whole& input) { input.all_loops[0].inliers = {{3, 4}}; }, "matches features 3 and 4");
}

}  // namespace nightmap::adjust_test
