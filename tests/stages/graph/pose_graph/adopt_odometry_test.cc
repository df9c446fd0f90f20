// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/adopt_odometry.h"

#include "pipeline/base/input_error.h"
#include "tests/stages/graph/pose_graph/circle_scene.h"

namespace nightmap::adopt_odometry_test {

// The circle of circle_scene.h, node by node, as a sensor measured it.
SensorEdges Drifted() {
  SensorEdges laser{"laser", {}};
  Random random(6);
  for (int i = 1; i < kNumFrames; ++i) {
    laser.edges.push_back(MakeEdge(EdgeKind::kOdometry, i - 1, i, 4e-4));
    Rigid3& motion = laser.edges.back().target_from_source;
    motion.translation += 0.02 * Eigen::Vector3d(random.Gaussian(), 0, random.Gaussian());
  }
  return laser;
}

// The last nodes with the first, exactly.
SensorEdges Loops() {
  SensorEdges laser{"laser", {}};
  for (int k = 0; k < 4; ++k) {
    laser.edges.push_back(MakeEdge(EdgeKind::kLoop, k, kNumFrames - 4 + k, 1e-5));
  }
  return laser;
}

PoseGraphInput Adopted(std::vector<SensorEdges> edges) {
  PoseGraphInput input;
  input.edges = std::move(edges);
  AdoptOdometry(&input);
  return input;
}

std::vector<Rigid3> Chained(const SensorEdges& laser) {
  std::vector<Rigid3> poses{Rigid3()};
  for (const SensorEdge& edge : laser.edges) {
    poses.push_back(poses.back() * edge.target_from_source.Inverse());
  }
  return poses;
}

TEST(AdoptOdometry, NodesOfASensorBecomeTheFrames) {
  const PoseGraphInput input = Adopted({Drifted()});
  ASSERT_EQ(input.frames.size(), static_cast<std::size_t>(kNumFrames));
  ASSERT_EQ(input.odometry.size(), 1U);
  const OdometryShard& shard = input.odometry[0];
  ASSERT_EQ(shard.frames.size(), static_cast<std::size_t>(kNumFrames));
  ASSERT_EQ(shard.edges.size(), static_cast<std::size_t>(kNumFrames - 1));
  for (int i = 0; i < kNumFrames; ++i) {
    const auto node = static_cast<std::size_t>(i);
    EXPECT_EQ(input.frames[node].frame_idx, i);
    EXPECT_EQ(input.frames[node].time_ns, TimeAt(i));
    EXPECT_EQ(shard.frames[node].frame_idx, i);
    EXPECT_TRUE(shard.frames[node].is_keyframe);
  }
  for (const PoseEdge& edge : shard.edges) EXPECT_FALSE(edge.is_bridge);
  ASSERT_EQ(input.edges.size(), 1U);
  EXPECT_TRUE(input.edges[0].edges.empty());
}

TEST(AdoptOdometry, EdgesOfALaserAloneGiveTheirChain) {
  const SensorEdges laser = Drifted();
  const PoseGraphResult result = Optimize(Adopted({laser}));
  const std::vector<Rigid3> chained = Chained(laser);
  ASSERT_EQ(result.graph_from_camera.size(), chained.size());
  for (std::size_t i = 0; i < chained.size(); ++i) {
    EXPECT_LT((result.graph_from_camera[i].translation - chained[i].translation).norm(), 1e-6);
    EXPECT_LT(AngleBetween_rad(result.graph_from_camera[i], chained[i]), 1e-6);
  }
  EXPECT_EQ(result.parts.size(), 1U);
}

TEST(AdoptOdometry, OtherEdgesStayInTheirFiles) {
  const PoseGraphInput input = Adopted({Drifted(), Loops()});
  ASSERT_EQ(input.edges.size(), 2U);
  EXPECT_TRUE(input.edges[0].edges.empty());
  EXPECT_EQ(input.edges[1].edges.size(), 4U);
  SensorEdges both = Drifted();
  const SensorEdges loops = Loops();
  both.edges.insert(both.edges.begin() + 7, loops.edges.begin(), loops.edges.end());
  const PoseGraphInput one_file = Adopted({both});
  EXPECT_EQ(one_file.odometry[0].edges.size(), static_cast<std::size_t>(kNumFrames - 1));
  ASSERT_EQ(one_file.edges[0].edges.size(), 4U);
  for (const SensorEdge& edge : one_file.edges[0].edges) EXPECT_EQ(edge.kind, EdgeKind::kLoop);
}

TEST(AdoptOdometry, TheFirstFileWithOdometryMakesTheNodes) {
  SensorEdges wheels = Drifted();
  wheels.sensor = "wheels";
  const PoseGraphInput input = Adopted({Loops(), Drifted(), wheels});
  EXPECT_EQ(input.frames.size(), static_cast<std::size_t>(kNumFrames));
  EXPECT_EQ(input.edges[0].edges.size(), 4U);
  EXPECT_TRUE(input.edges[1].edges.empty());
  EXPECT_EQ(input.edges[2].edges.size(), static_cast<std::size_t>(kNumFrames - 1));
}

TEST(AdoptOdometry, AGapBecomesABridge) {
  SensorEdges laser = Drifted();
  laser.edges.erase(laser.edges.begin() + 20);  // from node 20 to 21
  const PoseGraphInput input = Adopted({laser});
  ASSERT_EQ(input.frames.size(), static_cast<std::size_t>(kNumFrames));
  EXPECT_EQ(input.frames[21].time_ns, TimeAt(21));
  const std::vector<PoseEdge>& edges = input.odometry[0].edges;
  ASSERT_EQ(edges.size(), static_cast<std::size_t>(kNumFrames - 1));
  for (const PoseEdge& edge : edges) EXPECT_EQ(edge.is_bridge, edge.frame_a == 20);
  EXPECT_EQ(Optimize(input).parts.size(), 2U);
}

TEST(AdoptOdometry, LoopsJoinWhatABridgeParts) {
  SensorEdges laser = Drifted();
  laser.edges.erase(laser.edges.begin() + 20);
  const PoseGraphResult result = Optimize(Adopted({laser, Loops()}));
  EXPECT_EQ(result.parts.size(), 1U);
  EXPECT_LT(WorstError_m(result), 0.5);
}

// A drive of 3 km, and then another that begins again where the first did.
TEST(AdoptOdometry, LoopsJoinRecordingsThatBeginFarApart) {
  constexpr int kNumNodes = 31;
  SensorEdges laser = {"laser", {}};
  const auto drive = [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      laser.edges.push_back(MakeEdge(EdgeKind::kOdometry, i, i + 1));
      laser.edges.back().target_from_source = {Eigen::Quaterniond::Identity(), {-100, 0, 0}};
    }
  };
  drive(0, kNumNodes - 1);
  drive(kNumNodes, kNumNodes + 4);
  SensorEdges loops = {"laser", {}};
  for (int i = 0; i < 5; ++i) {
    loops.edges.push_back(MakeEdge(EdgeKind::kLoop, i, kNumNodes + i));
    loops.edges.back().target_from_source = {};
  }
  const PoseGraphResult result = Optimize(Adopted({laser, loops}));
  for (const LoopRecord& loop : result.loops) EXPECT_TRUE(loop.is_accepted) << loop.reason;
  EXPECT_EQ(result.parts.size(), 1U);
  EXPECT_LT(result.graph_from_camera[kNumNodes].translation.norm(), 1e-3);
}

TEST(AdoptOdometry, MotionsThatOverlapAreRefused) {
  SensorEdges laser = Drifted();
  laser.edges[5].source_time_ns -= 1;
  NIGHTMAP_EXPECT_ERROR(InputError, Adopted({laser}), "overlaps that before it");
  NIGHTMAP_EXPECT_ERROR(InputError, Adopted({laser}), std::to_string(TimeAt(5) - 1));
  laser = Drifted();
  laser.edges[5].target_time_ns = laser.edges[5].source_time_ns;
  NIGHTMAP_EXPECT_ERROR(InputError, Adopted({laser}), "overlaps that before it");
}

TEST(AdoptOdometry, TheErrorNamesTheFile) {
  SensorEdges laser = Drifted();
  laser.edges[5].source_time_ns -= 1;
  NIGHTMAP_EXPECT_ERROR(InputError, Adopted({Loops(), laser}), "edges[1]: ");
}

TEST(AdoptOdometry, WithoutOdometryThereIsNoMap) {
  NIGHTMAP_EXPECT_ERROR(InputError, Adopted({}), "no sensor measured motion");
  NIGHTMAP_EXPECT_ERROR(InputError, Adopted({Loops()}), "no sensor measured motion");
}

TEST(AdoptOdometry, LoopsCloseTheCircleOfADriftedSensor) {
  const double open_m = WorstError_m(Optimize(Adopted({Drifted()})));
  const PoseGraphResult result = Optimize(Adopted({Drifted(), Loops()}));
  EXPECT_LT(WorstError_m(result), 0.7 * open_m);
  EXPECT_TRUE(result.returns_to_start);
  ASSERT_EQ(result.loops.size(), 4U);
  for (const LoopRecord& loop : result.loops) EXPECT_TRUE(loop.is_accepted) << loop.reason;
  ASSERT_EQ(result.sensors.size(), 1U);
  EXPECT_EQ(result.sensors[0].num_loops, 4);
  EXPECT_EQ(result.sensors[0].num_refused, 0);
}

TEST(AdoptOdometry, AFalseLoopIsRefused) {
  const PoseGraphResult without = Optimize(Adopted({Drifted(), Loops()}));
  SensorEdges loops = Loops();
  loops.edges.push_back(MakeEdge(EdgeKind::kLoop, 1, kNumFrames - 2, 1e-5));
  loops.edges.back().target_from_source.translation.y() += 0.6;  // as drift might be
  loops.edges.push_back(MakeEdge(EdgeKind::kLoop, 0, kNumFrames / 2, 1e-5));
  loops.edges.back().target_from_source.translation.y() += 9;  // as no drift is
  const PoseGraphResult result = Optimize(Adopted({Drifted(), loops}));
  ASSERT_EQ(result.loops.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(result.loops[i].is_accepted, i < 4) << i;
  EXPECT_LT(WorstError_m(result), WorstError_m(without) + 0.02);
}

}  // namespace nightmap::adopt_odometry_test
