// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/closed_graph_io.h"

#include <functional>
#include <limits>

#include "pipeline/base/random.h"
#include "tests/io/artifact_damage.h"
#include "tests/io/hdf5_damage.h"

namespace nightmap::closed_graph_io_test {

const auto kRead = [](const std::filesystem::path& path) { return ReadClosedGraph(path); };

Rigid3 RandomPose(std::uint64_t seed) {
  Random random(7, seed);
  const Eigen::Quaterniond q(
      random.Gaussian(), random.Gaussian(), random.Gaussian(), random.Gaussian());
  return {q.normalized(), {random.Gaussian(), random.Gaussian(), 3}};
}

PoseEdge RandomEdge(int a, int b, bool is_bridge = false) {
  const auto seed = static_cast<std::uint64_t>(100 * (a + 2) + b);
  return {a, b, RandomPose(seed), (1 + 0.1 * b) * Matrix6d::Identity(), is_bridge};
}

// Six frames; loops replace the first of two bridges, and wheels filled another.
ClosedGraph SomeGraph() {
  ClosedGraph graph;
  graph.floor = {0.004, 0.003};
  for (std::uint64_t i = 0; i < 6; ++i) graph.chain.graph_from_camera.push_back(RandomPose(i));
  graph.chain.keyframes = {0, 2, 3, 5};
  for (const int idx : graph.chain.keyframes) {
    graph.graph_from_keyframe[idx] = RandomPose(static_cast<std::uint64_t>(idx + 50));
  }
  graph.chain.guessed = {1, 4};
  graph.chain.edges = {RandomEdge(0, 2, true), RandomEdge(2, 3), RandomEdge(3, 5, true)};
  graph.chain.after_bridge = {2, 5};
  graph.replaced_bridges = {2};
  graph.sensors = {{"wheels, \"left\"", {RandomEdge(0, 1), RandomEdge(1, 3)}, {}, {}},
                   {"survey", {}, {RandomEdge(1, 4)}, {RandomEdge(kMapNode, 4)}}};
  graph.filled = {{3, 0}};
  graph.is_loop_accepted = {true, false, true};
  return graph;
}

void ExpectEqual(const std::vector<PoseEdge>& read, const std::vector<PoseEdge>& written) {
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].frame_a, written[i].frame_a);
    EXPECT_EQ(read[i].frame_b, written[i].frame_b);
    EXPECT_EQ(read[i].b_from_a.Matrix(), written[i].b_from_a.Matrix());
    EXPECT_EQ(read[i].covariance, written[i].covariance);
    EXPECT_EQ(read[i].is_bridge, written[i].is_bridge);
  }
}

TEST(ClosedGraphIo, ReadsBackEveryField) {
  const TemporaryFolder folder;
  const ClosedGraph graph = SomeGraph();
  WriteClosedGraph(folder / "g.h5", graph, "x = 1\n");
  const ClosedGraph read = ReadClosedGraph(folder / "g.h5");
  EXPECT_EQ(read.floor.m, graph.floor.m);
  EXPECT_EQ(read.floor.rad, graph.floor.rad);
  ASSERT_EQ(read.chain.graph_from_camera.size(), 6U);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(read.chain.At(i).rotation.coeffs(), graph.chain.At(i).rotation.coeffs());
    EXPECT_EQ(read.chain.At(i).translation, graph.chain.At(i).translation);
  }
  EXPECT_EQ(read.chain.keyframes, graph.chain.keyframes);
  for (const auto& [idx, pose] : graph.graph_from_keyframe) {
    EXPECT_EQ(read.graph_from_keyframe.at(idx).rotation.coeffs(), pose.rotation.coeffs());
    EXPECT_EQ(read.graph_from_keyframe.at(idx).translation, pose.translation);
  }
  EXPECT_EQ(read.chain.guessed, graph.chain.guessed);
  EXPECT_EQ(read.chain.after_bridge, graph.chain.after_bridge);
  ExpectEqual(read.chain.edges, graph.chain.edges);
  EXPECT_EQ(read.replaced_bridges, graph.replaced_bridges);
  ASSERT_EQ(read.sensors.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.sensors[i].sensor, graph.sensors[i].sensor);
    ExpectEqual(read.sensors[i].odometry, graph.sensors[i].odometry);
    ExpectEqual(read.sensors[i].loops, graph.sensors[i].loops);
    ExpectEqual(read.sensors[i].priors, graph.sensors[i].priors);
  }
  EXPECT_EQ(read.filled, graph.filled);
  EXPECT_EQ(read.is_loop_accepted, graph.is_loop_accepted);
  WriteClosedGraph(folder / "again.h5", read, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder / "again.h5"), ReadBytes(folder / "g.h5"));
}

TEST(ClosedGraphIo, OneFrameIsFine) {
  const TemporaryFolder folder;
  ClosedGraph graph;
  graph.chain.graph_from_camera = {{}};
  graph.chain.keyframes = {0};
  graph.graph_from_keyframe[0] = {};
  WriteClosedGraph(folder / "g.h5", graph, "");
  EXPECT_TRUE(ReadClosedGraph(folder / "g.h5").chain.edges.empty());
}

TEST(ClosedGraphIo, ATruncatedFileIsNamed) {
  const TemporaryFolder folder;
  WriteClosedGraph(folder / "g.h5", SomeGraph(), "");
  ExpectTruncationIsNamed(folder, folder / "g.h5", kRead);
}

TEST(ClosedGraphIo, DamagedBytesAreSurvived) {
  const TemporaryFolder folder;
  WriteClosedGraph(folder / "g.h5", SomeGraph(), "size = 1\n");
  ExpectDamageIsSurvived(folder, folder / "g.h5", kRead);
}

TEST(ClosedGraphIo, AnotherFormatAndANewerVersionAreRefused) {
  ExpectOtherFormatsAreRefused(TemporaryFolder(), "nightmap pose graph", 1, kRead);
}

TEST(ClosedGraphIo, WhatDoesNotFitTogetherIsNamed) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::function<void(ClosedGraph&)>& damage,
                          const std::string& field) {
    ClosedGraph graph = SomeGraph();
    damage(graph);
    WriteClosedGraph(folder / "g.h5", graph, "");
    NIGHTMAP_EXPECT_ERROR(
        DataError, ReadClosedGraph(folder / "g.h5"), "g.h5: field '" + field + "'");
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  refuse([](ClosedGraph& g) { g.floor.m = kNan; }, "sigma_floor");
  refuse([](ClosedGraph& g) { g.chain.graph_from_camera[4].translation.x() = kNan; },
         "odometry_from_camera");
  refuse([](ClosedGraph& g) { g.graph_from_keyframe.at(3).translation.x() = kNan; },
         "graph_from_keyframe");
  refuse([](ClosedGraph& g) { g.chain.edges[1].covariance(2, 2) = kNan; }, "edge_covariance");
  refuse([](ClosedGraph& g) { g.sensors[0].odometry[1].b_from_a.translation.y() = kNan; },
         "edge_b_from_a");
  refuse([](ClosedGraph& g) { g.graph_from_keyframe.erase(0); }, "keyframe_idx");
  refuse([](ClosedGraph& g) { g.graph_from_keyframe[6] = {}; }, "keyframe_idx");
  refuse([](ClosedGraph& g) { g.chain.edges[1].frame_a = 0; }, "edge_frame");
  refuse([](ClosedGraph& g) { g.chain.edges[2].frame_b = 4; }, "edge_frame");
  refuse([](ClosedGraph& g) { g.sensors[1].loops[0].frame_b = 6; }, "edge_frame");
  refuse([](ClosedGraph& g) { g.sensors[1].loops[0].frame_a = kMapNode; }, "edge_frame");
  refuse([](ClosedGraph& g) { g.sensors[1].priors[0].frame_a = 0; }, "edge_frame");
  refuse([](ClosedGraph& g) { g.filled = {{3, 2}}; }, "filled_bridge");
  refuse([](ClosedGraph& g) { g.filled = {{4, 0}}; }, "filled_bridge");
}

// A file of another program.
TEST(ClosedGraphIo, SizesKindsAndSensorsThatCannotBeAreNamed) {
  const TemporaryFolder folder;
  const auto refuse =
      [&](const std::string& damaged, const std::string& text, std::uint8_t kind, int sensor) {
        {
          Hdf5Writer file(folder / "g.h5", "nightmap pose graph", 1, "", "");
          const Array<double> poses{2, 7, {0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1}};
          file.WriteText("sensors", damaged == "sensors" ? "{" : "[\"wheels\"]");
          file.WriteList("sigma_floor", std::vector<double>(damaged == "sigma_floor" ? 1 : 2, 0.1));
          file.Write("odometry_from_camera", poses);
          file.WriteList("is_guessed", std::vector<std::uint8_t>(2));
          file.WriteList("keyframe_idx", std::vector<std::int32_t>{0, 1});
          file.Write("graph_from_keyframe", poses);
          file.WriteList("edge_kind", std::vector<std::uint8_t>{kind});
          file.WriteList("edge_sensor", std::vector<std::int32_t>{sensor});
          file.Write("edge_frame", Array<std::int32_t>{1, 2, {0, 1}});
          file.Write("edge_b_from_a", Array<double>{1, 7, {0, 0, 0, 0, 0, 0, 1}});
          file.Write("edge_covariance", Array<double>{1, 36, std::vector<double>(36)});
          file.WriteList("is_loop_accepted", std::vector<std::uint8_t>{});
          file.Write("filled_bridge", Array<std::int32_t>{0, 2, {}});
          file.Close();
        }
        if (text.empty()) {
          EXPECT_EQ(ReadClosedGraph(folder / "g.h5").chain.edges.size(), 1U);
        } else {
          NIGHTMAP_EXPECT_ERROR(
              DataError, ReadClosedGraph(folder / "g.h5"), "g.h5: field '" + text);
        }
      };
  refuse("", "", 0, -1);
  refuse("sensors", "sensors'", 0, -1);
  refuse("sigma_floor", "sigma_floor'", 0, -1);
  refuse("", "edge_kind'", 5, -1);
  refuse("", "edge_kind'", 3, -1);
  refuse("", "edge_kind' has a bridge of a sensor", 1, 0);
  refuse("", "edge_sensor' names no sensor", 0, 1);
}

}  // namespace nightmap::closed_graph_io_test
