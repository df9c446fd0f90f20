// SPDX-License-Identifier: Apache-2.0
// Round trips and corruption of g2o, matches and odometry files.
#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/g2o_io.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

const Rigid3 kPose{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())), {1, 2, 3}};

TEST(G2oIo, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  Matrix6d covariance = 0.01 * Matrix6d::Identity();
  covariance(0, 4) = covariance(4, 0) = 0.002;
  const PoseGraph graph{{{0, Rigid3()}, {7, kPose}}, {{0, 7, kPose, covariance, false}}};
  WriteFile(folder.Path() / "g.g2o", PoseGraphToG2o(graph));
  const PoseGraph read = ReadG2o(folder.Path() / "g.g2o");
  ASSERT_EQ(read.vertices.size(), 2U);
  ASSERT_EQ(read.edges.size(), 1U);
  EXPECT_LT((read.vertices[1].map_from_camera.Matrix() - kPose.Matrix()).norm(), 1e-6);
  EXPECT_LT((read.edges[0].b_from_a.Matrix() - kPose.Matrix()).norm(), 1e-6);
  EXPECT_LT((read.edges[0].covariance - covariance).norm(), 1e-6);
}

TEST(G2oIo, RefusesBadLines) {
  const TemporaryFolder folder;
  for (const char* text : {"VERTEX_SE3:QUAT 0 nan 0 0 0 0 0 1\n",
                           "VERTEX_SE3:QUAT 0 0 0 0 0 0\n",
                           "VERTEX_SE2 0 0 0 0\n",
                           "EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1\n"}) {
    WriteFile(folder.Path() / "bad.g2o", text);
    EXPECT_THROW(ReadG2o(folder.Path() / "bad.g2o"), DataError) << text;
  }
}

TEST(MatchesIo, RoundTripAndTruncation) {
  const TemporaryFolder folder;
  const auto path = folder.Path() / "m.h5";
  FramePair pair;
  pair.frame_a = 3;
  pair.frame_b = 9;
  pair.status = PairStatus::kAccepted;
  pair.b_from_a = kPose;
  pair.inliers = {{1, 2}, {5, 6}};
  FramePair rejected;
  rejected.frame_b = 1;
  WritePairs(path, {pair, rejected}, "x = 1\n");
  const auto read = ReadPairs(path);
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].frame_b, 9);
  EXPECT_EQ(read[0].inliers[1].b, 6);
  EXPECT_EQ(read[0].b_from_a.Matrix(), kPose.Matrix());
  EXPECT_EQ(read[1].status, PairStatus::kTooFewMatches);
  const std::string bytes = ReadFile(path);
  for (const double share : {0.1, 0.5, 0.9}) {
    WriteFile(path,
              bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
    EXPECT_THROW(ReadPairs(path), DataError) << share;
  }
}

TEST(OdometryIo, EqualContentGivesEqualBytesAndReadsBack) {
  const TemporaryFolder folder;
  const OdometryShard shard{{{4, kPose, TrackingState::kBridged, true}},
                            {{3, 4, kPose, Matrix6d::Identity(), true}},
                            {{0, 3, 7}, {0, 4, 8}}};
  WriteOdometry(folder.Path() / "a.h5", shard, "");
  WriteOdometry(folder.Path() / "b.h5", shard, "");
  EXPECT_EQ(ReadFile(folder.Path() / "a.h5"), ReadFile(folder.Path() / "b.h5"));
  const OdometryShard read = ReadOdometry(folder.Path() / "a.h5");
  ASSERT_EQ(read.frames.size(), 1U);
  EXPECT_EQ(read.frames[0].state, TrackingState::kBridged);
  EXPECT_TRUE(read.edges.at(0).is_bridge);
  EXPECT_EQ(read.observations.at(1).feature_idx, 8);
}

TEST(Hdf5File, RefusesOtherFormatNewerVersionAndNan) {
  const TemporaryFolder folder;
  const auto path = folder.Path() / "a.h5";
  Hdf5Writer writer(path, "thing", 3, "", "");
  writer.WriteList<double>("bad", {1.0, std::nan("")});
  writer.WriteList<std::int32_t>("list", {1, 2});
  writer.Close();
  EXPECT_THROW(Hdf5Reader(path, "other", 3), DataError);
  EXPECT_THROW(Hdf5Reader(path, "thing", 2), DataError);
  const Hdf5Reader reader(path, "thing", 3);
  EXPECT_EQ(reader.ReadList<std::int32_t>("list").size(), 2U);
  EXPECT_THROW(reader.ReadList<double>("bad"), DataError);
  EXPECT_THROW(reader.ReadList<double>("list"), DataError);
  EXPECT_THROW(reader.ReadList<double>("missing"), DataError);
  EXPECT_THROW(reader.Read<std::int32_t>("list", 2), DataError);
}

}  // namespace
}  // namespace nightmap
