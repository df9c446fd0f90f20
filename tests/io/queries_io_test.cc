// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/queries_io.h"

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::queries_io_test {

constexpr char kHeader[] =
    "query_idx,time_ns,color_path,status,reason,num_matches,num_inliers,num_rival_inliers,"
    "confidence,"
    "reprojection_error_px,position_sigma_m,rotation_sigma_deg,tx_m,ty_m,tz_m,qx,qy,qz,qw\n";

std::vector<QueryResult> MakeQueries() {
  const Rigid3 pose{Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX())),
                    {0.1, -2, 1e-7}};
  return {
      {0, 2000000000, "a,b.png", QueryVerdict::kLocated, "", 90, 80, 7, 0.9, 1.25, 0.01, 0.2, pose},
      {1, 1000000000, "c.png", QueryVerdict::kNotInMap, "too_few_matches", 3, 0, 0, 0, 0, 0, 0, {}},
      {2, 3, "d.png", QueryVerdict::kAmbiguous, "rival", 50, 40, 38, 0.05, 1, 0.1, 1, pose}};
}

class QueriesIoTest : public testing::Test {
 protected:
  void ExpectRefused(const std::string& rows, const std::string& text) const {
    const auto path = folder_.Write("queries.csv", kHeader + rows);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadQueries(path), text, "queries.csv");
  }
  TemporaryFolder folder_;
};

TEST_F(QueriesIoTest, ReadsWhatItWrote) {
  const std::string text = QueriesToCsv(MakeQueries());
  const auto read = ReadQueries(folder_.Write("queries.csv", text));
  ASSERT_EQ(read.size(), 3U);
  EXPECT_TRUE(read[0].IsLocated());
  EXPECT_EQ(read[0].color_path, "a,b.png");
  EXPECT_EQ(read[0].num_inliers, 80);
  EXPECT_EQ(read[0].map_from_camera.Matrix(), MakeQueries()[0].map_from_camera.Matrix());
  EXPECT_EQ(read[1].reason, "too_few_matches");
  EXPECT_FALSE(read[1].HasPose());
  EXPECT_EQ(read[2].verdict, QueryVerdict::kAmbiguous);
  EXPECT_TRUE(read[2].HasPose());
  EXPECT_EQ(QueriesToCsv(read), text);
}

TEST_F(QueriesIoTest, OnlyLocatedQueriesMakeATrajectory) {
  auto queries = MakeQueries();
  queries.push_back(queries[0]);
  queries[3].time_ns = 1;
  const auto poses = LocatedPoses(queries);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].time_ns, 1);
  EXPECT_EQ(poses[1].time_ns, 2000000000);
}

TEST_F(QueriesIoTest, RefusesContradictions) {
  ExpectRefused("0,1,a.png,lost,x,1,1,0,0,0,0,0,,,,,,,\n", "status");
  ExpectRefused("0,1,a.png,not_in_map,,1,1,0,0,0,0,0,,,,,,,\n", "without reason");
  ExpectRefused("0,1,a.png,not_in_map,x,1,1,0,0,0,0,0,1,,,,,,\n", "with a pose");
  ExpectRefused("0,1,a.png,ambiguous,x,1,1,0,0,0,0,0,,,,,,,\n", "tx_m");
  ExpectRefused("0,1,a.png,located,x,1,1,0,0,0,0,0,0,0,0,0,0,0,1\n", "reason of failure");
  ExpectRefused("0,1,a.png,located,,1,1,0,0,0,0,0,0,0,0,0,0,0,2\n", "unit length");
  ExpectRefused("0,1,a.png,located,,1,1,0,0,0,0,0,0,nan,0,0,0,0,1\n", "ty_m");
  ExpectRefused("0,1,a.png,located,,1,1,0,nan,0,0,0,0,0,0,0,0,0,1\n", "confidence");
  ExpectRefused("0,1,a.png,located,,1,1,0,0,0,0,0,,,,,,,\n", "tx_m");
}

TEST_F(QueriesIoTest, RefusesTruncatedFilesAndOtherHeaders) {
  const std::string text = QueriesToCsv(MakeQueries());
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadQueries(folder_.Write("queries.csv", text.substr(0, text.size() - 5))),
                        "queries.csv");
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadQueries(folder_.Write("queries.csv", "query_idx\n0\n")), "queries.csv");
}

}  // namespace nightmap::queries_io_test
