// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/sensor_edges.h"

#include "stages/graph/pose_graph/pose_graph_output.h"
#include "tests/stages/graph/pose_graph/circle_scene.h"

namespace nightmap::sensor_edges_test {

constexpr int kLost = 12;   // first frame without a pair
constexpr int kFound = 18;  // keyframe of a part of its own

SensorEdges Wheels(int first, int last, int step = 1) {
  SensorEdges wheels{"wheels", {}};
  for (int i = first; i + step <= last; i += step) {
    wheels.edges.push_back(MakeEdge(EdgeKind::kOdometry, i, i + step));
  }
  return wheels;
}

// From kLost on the camera saw nothing; at kFound it goes on somewhere else. No loop helps.
PoseGraphInput MakeBlindInput() {
  PoseGraphInput input = MakeInput(0);
  OdometryShard& shard = input.odometry[0];
  for (OdometryFrame& frame : shard.frames) {
    if (frame.frame_idx < kLost) continue;
    if (frame.frame_idx >= kFound) {
      frame.shard_from_camera = Elsewhere() * frame.shard_from_camera;
      continue;
    }
    frame.shard_from_camera = shard.frames[kLost - 1].shard_from_camera;
    frame.state = TrackingState::kBridged;
    frame.is_keyframe = false;
  }
  shard.frames[kFound].state = TrackingState::kStarted;
  std::erase_if(shard.edges, [](const PoseEdge& edge) {
    return edge.frame_b >= kLost && edge.frame_b < kFound;
  });
  for (PoseEdge& edge : shard.edges) {
    if (edge.frame_b != kFound) continue;
    edge = {kLost - 3,
            kFound,
            shard.frames[kFound].shard_from_camera.Inverse() *
                shard.frames[kLost - 3].shard_from_camera,
            100 * Matrix6d::Identity(),
            true};
  }
  return input;
}

double Error_m(const Rigid3& map_from_truth, const PoseGraphResult& result, int frame_idx) {
  return (result.graph_from_camera[static_cast<std::size_t>(frame_idx)].translation -
          (map_from_truth * TruePose(frame_idx)).translation)
      .norm();
}

TEST(SensorEdges, WheelsHoldAStretchWithoutPairsTogether) {
  const double seeing_m = WorstError_m(Optimize(MakeInput(0)));
  PoseGraphInput input = MakeBlindInput();
  const PoseGraphResult alone = Optimize(input);
  EXPECT_EQ(alone.parts.size(), 2U);
  EXPECT_GT(WorstError_m(alone), seeing_m + 1);
  // Every frame; nodes beside the keyframes; one edge past all frames that the camera lost.
  for (const SensorEdges& wheels : {Wheels(5, 25), Wheels(4, 28, 3), Wheels(10, 20, 10)}) {
    input.edges = {wheels};
    const PoseGraphResult result = Optimize(input);
    EXPECT_EQ(result.parts.size(), 1U);
    EXPECT_EQ(Summarize(input, result).at("num_bridges"), 0);
    EXPECT_LT(WorstError_m(result), seeing_m + 0.1);
    ASSERT_EQ(result.sensors.size(), 1U);
    EXPECT_EQ(result.sensors[0].num_odometry, static_cast<int>(wheels.edges.size()));
    EXPECT_EQ(result.sensors[0].num_refused, 0);
  }
}

TEST(SensorEdges, FramesThatTheCameraLostFollowTheWheels) {
  PoseGraphInput input = MakeBlindInput();
  input.edges = {Wheels(kLost - 1, kFound)};
  const PoseGraphResult result = Optimize(input);
  for (int i = kLost; i < kFound; ++i) {
    const Rigid3 from_last = result.graph_from_camera[kLost - 1].Inverse() *
                             result.graph_from_camera[static_cast<std::size_t>(i)];
    const Rigid3 truth = TrueRelative(i, kLost - 1);
    EXPECT_LT((from_last.translation - truth.translation).norm(), 0.02) << i;
    EXPECT_LT(AngleBetween_rad(from_last, truth), 0.02) << i;
  }
}

TEST(SensorEdges, OdometryOfASensorReducesTheCamerasDrift) {
  PoseGraphInput input = MakeInput(0);
  const double open_m = WorstError_m(Optimize(input));
  input.edges = {Wheels(0, 20), Wheels(20, kNumFrames - 1)};  // shards of one sensor
  const PoseGraphResult result = Optimize(input);
  EXPECT_LT(WorstError_m(result), 0.4 * open_m);
  ASSERT_EQ(result.sensors.size(), 1U);
  const nlohmann::json report = Summarize(input, result).at("sensors").at(0);
  EXPECT_EQ(report.at("sensor"), "wheels");
  EXPECT_EQ(report.at("num_edges"), kNumFrames - 1);
  EXPECT_GT(report.at("median_normalized_residual"), 0);
}

TEST(SensorEdges, LoopsOfASensorCloseTheCircleFromEitherEnd) {
  PoseGraphInput input = MakeInput(0);
  const double open_m = WorstError_m(Optimize(input));
  for (const bool is_backward : {false, true}) {
    SensorEdges laser{"laser", {}};
    for (int k = 0; k < 4; ++k) {
      const int late = kNumFrames - 4 + k;
      laser.edges.push_back(
          MakeEdge(EdgeKind::kLoop, is_backward ? late : k, is_backward ? k : late));
    }
    input.edges = {laser};
    const PoseGraphResult result = Optimize(input);
    EXPECT_LT(WorstError_m(result), 0.7 * open_m);
    EXPECT_TRUE(result.returns_to_start);
    ASSERT_EQ(result.loops.size(), 4U);
    for (const LoopRecord& loop : result.loops) EXPECT_TRUE(loop.is_accepted) << loop.reason;
  }
}

TEST(SensorEdges, AFalseLoopOfASensorIsRefused) {
  PoseGraphInput input = MakeInput();
  const PoseGraphResult without = Optimize(input);
  SensorEdges laser{"laser", {MakeEdge(EdgeKind::kLoop, 2, kNumFrames - 2)}};
  laser.edges.push_back(MakeEdge(EdgeKind::kLoop, 0, kNumFrames - 3));
  laser.edges.back().target_from_source.translation.y() += 0.6;  // as drift might be
  laser.edges.push_back(MakeEdge(EdgeKind::kLoop, 0, 24));
  laser.edges.back().target_from_source.translation.y() += 9;  // as no drift is
  input.edges = {laser};
  const PoseGraphResult result = Optimize(input);
  ASSERT_EQ(result.sensors.size(), 1U);
  EXPECT_EQ(result.sensors[0].num_loops, 3);
  EXPECT_EQ(result.sensors[0].num_refused, 2);
  EXPECT_LT(WorstError_m(result), WorstError_m(without) + 0.02);
}

const Rigid3 kMapFromTruth{
    Eigen::Quaterniond(Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, 3).normalized())),
    {50, -20, 3}};

TEST(SensorEdges, PriorsPullTheMapToThem) {
  PoseGraphInput input = MakeInput(0);
  input.edges = {Survey({4, 24, kNumFrames - 1}, kMapFromTruth)};  // 4 is no keyframe
  const PoseGraphResult result = Optimize(input);
  for (const int i : {24, kNumFrames - 1}) EXPECT_LT(Error_m(kMapFromTruth, result, i), 0.01);
  for (int i = 0; i < kNumFrames; ++i) EXPECT_LT(Error_m(kMapFromTruth, result, i), 0.15) << i;
  EXPECT_EQ(result.sensors.at(0).num_priors, 3);
  EXPECT_EQ(result.parts.size(), 1U);
  for (const PoseEdge& edge : result.edges) EXPECT_GE(edge.frame_a, 0);
}

// Only x of the map is known at the last frame: y and z of that prior are off.
TEST(SensorEdges, APriorPullsAlongTheAxesThatItMeasures) {
  PoseGraphInput input = MakeInput(0);
  input.edges = {Survey({0, kNumFrames - 1}, kMapFromTruth)};
  SensorEdge& last = input.edges[0].edges.back();
  last.covariance = 1e6 * Matrix6d::Identity();
  last.covariance(3, 3) = 1e-6;
  last.target_from_source.translation += Eigen::Vector3d(0, 0.7, -0.7);
  const Rigid3 result = Optimize(input).graph_from_camera.back();
  const Eigen::Vector3d error =
      result.translation - (kMapFromTruth * TruePose(kNumFrames - 1)).translation;
  EXPECT_LT(std::abs(error.x()),
            0.03);  // the drift's rotation tilts x by 0.02 of the metre it is off
  EXPECT_LT(error.norm(), 0.5);
}

// Two stretches that nothing joins are where their priors put them.
TEST(SensorEdges, PriorsPlaceParts) {
  PoseGraphInput input = MakeBlindInput();
  input.edges = {Survey({0, 9, 18, 36})};
  const PoseGraphResult result = Optimize(input);
  for (const int i : {0, 9, 18, 36}) EXPECT_LT(Error_m({}, result, i), 0.02) << i;
  EXPECT_EQ(result.parts.size(), 1U);
}

TEST(SensorEdges, WithoutEdgesTheReportNamesNoSensor) {
  const PoseGraphInput input = MakeInput();
  EXPECT_FALSE(Summarize(input, Optimize(input)).contains("sensors"));
}

TEST(SensorEdges, EdgesOfOtherFramesAreRefused) {
  PoseGraphInput input = MakeInput();
  input.edges = {Wheels(0, 9), Wheels(9, 20)};
  input.edges[1].edges[3].target_time_ns += 1;
  NIGHTMAP_EXPECT_ERROR(
      DataError, Optimize(input), "edges[1]: an edge has node time_ns 14000000001");
  input.edges = {Wheels(0, 9), Wheels(8, 20)};
  NIGHTMAP_EXPECT_ERROR(
      DataError, Optimize(input), "sensor 'wheels' between frames 8 and 9 overlaps");
}

}  // namespace nightmap::sensor_edges_test
