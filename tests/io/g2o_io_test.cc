// SPDX-License-Identifier: Apache-2.0

#include "pipeline/io/g2o_io.h"
#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::g2o_io_test {

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
                           "VERTEX_SE3:QUAT 1e300 0 0 0 0 0 0 1\n",
                           "VERTEX_SE3:QUAT -1 0 0 0 0 0 0 1\n",
                           "VERTEX_SE3:QUAT 0.5 0 0 0 0 0 0 1\n",
                           "EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1\n"}) {
    WriteFile(folder.Path() / "bad.g2o", text);
    EXPECT_THROW(ReadG2o(folder.Path() / "bad.g2o"), DataError) << text;
  }
}

}  // namespace nightmap::g2o_io_test
