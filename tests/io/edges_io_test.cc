// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/edges_io.h"

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::edges_io_test {

SensorEdge RandomEdge(EdgeKind kind, std::int64_t source_ns, std::int64_t target_ns) {
  Random random(1, static_cast<std::uint64_t>(source_ns));
  SensorEdge edge{kind, source_ns, target_ns, {}, {}};
  const Eigen::Quaterniond q(
      random.Gaussian(), random.Gaussian(), random.Gaussian(), random.Gaussian());
  edge.target_from_source = {q.normalized(), {random.Gaussian(), random.Gaussian(), 3}};
  Matrix6d root;
  for (double& value : root.reshaped()) value = random.Gaussian();
  edge.covariance = root * root.transpose() + Matrix6d::Identity();
  return edge;
}

SensorEdges SomeEdges() {
  return {"wheels, \"left\"",
          {RandomEdge(EdgeKind::kOdometry, 100, 200),
           RandomEdge(EdgeKind::kLoop, 900, 100),
           RandomEdge(EdgeKind::kOdometry, 200, 300),
           RandomEdge(EdgeKind::kPrior, 200, 200),
           RandomEdge(EdgeKind::kOdometry, 500, 900)}};
}

class EdgesIo : public InFolder {};

TEST_F(EdgesIo, ReadsBackEveryField) {
  const SensorEdges edges = SomeEdges();
  WriteEdges(folder_ / "e.h5", edges, "x = 1\n");
  const SensorEdges read = ReadEdges(folder_ / "e.h5");
  EXPECT_EQ(read.sensor, edges.sensor);
  ASSERT_EQ(read.edges.size(), edges.edges.size());
  for (std::size_t i = 0; i < edges.edges.size(); ++i) {
    EXPECT_EQ(read.edges[i].kind, edges.edges[i].kind);
    EXPECT_EQ(read.edges[i].source_time_ns, edges.edges[i].source_time_ns);
    EXPECT_EQ(read.edges[i].target_time_ns, edges.edges[i].target_time_ns);
    EXPECT_EQ(read.edges[i].target_from_source.Matrix(),
              edges.edges[i].target_from_source.Matrix());
    EXPECT_EQ(read.edges[i].covariance, edges.edges[i].covariance);
  }
  WriteEdges(folder_ / "again.h5", read, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder_ / "again.h5"), ReadBytes(folder_ / "e.h5"));
}

TEST_F(EdgesIo, TheMountingIsReadBackWhereItIsKnown) {
  SensorEdges edges = SomeEdges();
  WriteEdges(folder_ / "without.h5", edges, "");
  EXPECT_FALSE(ReadEdges(folder_ / "without.h5").mounting.has_value());
  edges.mounting = Mounting{edges.edges[0].target_from_source,
                            {edges.edges[1].target_from_source, edges.edges[2].target_from_source}};
  WriteEdges(folder_ / "e.h5", edges, "");
  const SensorEdges read = ReadEdges(folder_ / "e.h5");
  ASSERT_TRUE(read.mounting.has_value());
  EXPECT_EQ(read.mounting->robot_from_sensor.Matrix(), edges.mounting->robot_from_sensor.Matrix());
  ASSERT_EQ(read.mounting->robot_from_camera.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.mounting->robot_from_camera[i].Matrix(),
              edges.mounting->robot_from_camera[i].Matrix());
  }
}

TEST_F(EdgesIo, NoEdgesAreFine) {
  WriteEdges(folder_ / "e.h5", {"wheels", {}}, "");
  EXPECT_TRUE(ReadEdges(folder_ / "e.h5").edges.empty());
}

// A file of another program.
TEST_F(EdgesIo, NoSensorUnknownKindsAndWhatIsNoCovarianceAreNamed) {
  const auto refuse = [&](const char* sensor, std::uint8_t kind, const std::string& text) {
    {
      Hdf5Writer file(folder_ / "e.h5", "nightmap edges", 1, "", "");
      file.WriteText("sensor", sensor);
      file.WriteList<std::uint8_t>("kind", {kind});
      file.Write("time_ns", Array<std::int64_t>{1, 2, {1, 2}});
      file.Write("target_from_source", Array<double>{1, 7, {0, 0, 0, 0, 0, 0, 1}});
      file.Write("covariance", Array<double>{1, 36, std::vector<double>(36)});
      file.Close();
    }
    NIGHTMAP_EXPECT_ERROR(DataError, ReadEdges(folder_ / "e.h5"), "e.h5: field '" + text);
  };
  refuse("", 0, "sensor' is empty");
  refuse("wheels", 3, "kind' has an unknown kind");
  refuse("wheels", 0, "covariance' is not symmetric and positive definite");
}

class EdgesIoTest : public testing::Test {
 protected:
  void ExpectRefused(const std::function<void(std::vector<SensorEdge>&)>& damage,
                     const std::string& text) const {
    SensorEdges edges = SomeEdges();
    damage(edges.edges);
    WriteEdges(folder_ / "e.h5", edges, "");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadEdges(folder_ / "e.h5"), "e.h5: " + text);
  }
  TemporaryFolder folder_;
};

using Edges = std::vector<SensorEdge>;

TEST_F(EdgesIoTest, NanAndInfinityAreNamed) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    ExpectRefused([&](Edges& edges) { edges[1].target_from_source.translation.y() = bad; },
                  "field 'target_from_source'");
    ExpectRefused([&](Edges& edges) { edges[4].covariance(5, 5) = bad; }, "field 'covariance'");
  }
}

TEST_F(EdgesIoTest, WhatIsNoCovarianceIsRefused) {
  const std::string why = "field 'covariance' is not symmetric and positive definite";
  ExpectRefused([](Edges& edges) { edges[1].covariance(0, 5) += 0.01; }, why);
  ExpectRefused([](Edges& edges) { edges[1].covariance *= -1; }, why);
  ExpectRefused([](Edges& edges) { edges[1].covariance.setZero(); }, why);
  ExpectRefused([](Edges& edges) { edges[2].covariance.setOnes(); }, why);
  ExpectRefused([](Edges& edges) { edges[3].covariance = 1e-310 * Matrix6d::Identity(); }, why);
}

TEST_F(EdgesIoTest, APoseThatIsNoneIsRefused) {
  ExpectRefused([](Edges& edges) { edges[2].target_from_source.rotation.coeffs() *= 2; },
                "row 2 holds a quaternion");
}

TEST_F(EdgesIoTest, NodesThatCannotBeAreRefused) {
  ExpectRefused([](Edges& edges) { edges[1].target_time_ns = 900; },
                "field 'time_ns' has an edge from a node to itself");
  ExpectRefused([](Edges& edges) { edges[3].target_time_ns = 300; },
                "field 'time_ns' has two nodes for a prior");
  const auto again = [](std::size_t i) {
    return [i](Edges& edges) {
      edges.push_back(edges[i]);
      std::swap(edges.back().source_time_ns, edges.back().target_time_ns);
    };
  };
  for (const std::size_t i : {0U, 1U, 3U}) {
    ExpectRefused(again(i), "field 'time_ns' has an edge twice");
  }
  const std::string not_ascending = "field 'time_ns' has odometry that does not ascend";
  ExpectRefused([](Edges& edges) { edges[2].source_time_ns = 199; }, not_ascending);
  ExpectRefused([](Edges& edges) { edges[4].target_time_ns = 400; }, not_ascending);
}

}  // namespace nightmap::edges_io_test
