// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/path_io.h"

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

constexpr char kHeader[] = "x_m,y_m,heading_rad,distance_m\n";
constexpr char kRows[] = "1.5,2,0,0\n2.5,2,0.5,1\n";

std::string Json(const std::string& config, int num_points = 2, int version = 1) {
  return "{\"format\": \"nightmap_path\", \"version\": " + std::to_string(version) +
         ", \"num_points\": " + std::to_string(num_points) + ", \"config\": \"" + config + "\"}";
}

class PathIoTest : public testing::Test {
 protected:
  PlannedPath Read(const std::string& csv, const std::string& json) const {
    return ReadPlannedPath(folder_.Write("path.csv", csv), folder_.Write("path.json", json));
  }
  TemporaryFolder folder_;
};

TEST_F(PathIoTest, ReadsPointsAndWhatTheyWerePlannedFor) {
  const PlannedPath path =
      Read(std::string(kHeader) + kRows,
           Json("robot_radius_m = 0.25\\nunknown_is_obstacle = false\\nother = \\\"x\\\"\\n"));
  ASSERT_EQ(path.points_in_map.size(), 2U);
  EXPECT_EQ(path.points_in_map[1], Eigen::Vector2d(2.5, 2));
  EXPECT_EQ(path.goal_heading_rad, 0.5);
  EXPECT_EQ(path.robot_radius_m, 0.25);
  EXPECT_TRUE(path.may_cross_unknown);
}

TEST_F(PathIoTest, FurtherColumnsMayFollow) {
  const PlannedPath path =
      Read("x_m,y_m,heading_rad,distance_m,leg_idx\n1,2,0.5,0,0\n", Json("", 1));
  EXPECT_EQ(path.points_in_map[0], Eigen::Vector2d(1, 2));
  EXPECT_FALSE(path.robot_radius_m.has_value());
  EXPECT_FALSE(path.may_cross_unknown);
}

TEST_F(PathIoTest, RefusesDamagedPoints) {
  const std::string header = kHeader;
  NIGHTMAP_EXPECT_ERROR(DataError, Read(header, Json("", 0)), "no point");
  NIGHTMAP_EXPECT_ERROR(DataError, Read("x_m,y_m,distance_m\n1,2,3\n", Json("", 1)), "begin with");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(header + "1,nan,0,0\n", Json("", 1)), "y_m");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(header + "1,2,0\n", Json("", 1)), "path.csv:2");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(header + "1,2,0,0,7\n", Json("", 1)), "5 fields");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(header + "1,2,0,0", Json("", 1)), "truncated");
}

TEST_F(PathIoTest, RefusesAnotherJson) {
  const std::string csv = std::string(kHeader) + kRows;
  NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, Json("", 3)), "make plan");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, Json("", 2, 2)), "newer");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, "{\"format\": \"other\"}"), "not a planned path");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, "{\"format\": "), "path.json");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, "{\"format\": \"nightmap_path\"}"), "version");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, Json("a = = 1")), "path.json: config");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, Json("robot_radius_m = nan")), "robot_radius_m");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, Json("robot_radius_m = -1")), "robot_radius_m");
}

}  // namespace
}  // namespace nightmap
