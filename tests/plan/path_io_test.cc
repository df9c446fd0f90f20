// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/path_io.h"

#include "tests/test_data.h"

namespace nightmap::path_io_test {

const std::string kHeader = "x_m,y_m,heading_rad,distance_m,leg_idx,clearance_m\n";
const std::string kCsv = kHeader + "1.5,2,0,0,0,1\n2.5,2,0.5,1,0,1\n3,2,0,0.5,1,1\n";
constexpr char kConfig[] = "robot_radius_m = 0.25\\nunknown = \\\"forbidden\\\"\\n";

std::string Json(const std::string& config, int num_points = 3, int version = 3) {
  return "{\"format\": \"nightmap_path\", \"version\": " + std::to_string(version) +
         ", \"floor\": 1, \"num_legs\": 2, \"length_m\": 1.5, \"num_points\": " +
         std::to_string(num_points) + ", \"config\": \"" + config + "\"}";
}

class PathIoTest : public testing::Test {
 protected:
  PlannedPath Read(const std::string& csv, const std::string& json) const {
    return ReadPlannedPath(folder_.Write("path.csv", csv), folder_.Write("path.json", json));
  }
  TemporaryFolder folder_;
};

TEST_F(PathIoTest, ReadsLegsAndWhatTheyWerePlannedFor) {
  const PlannedPath path = Read(kCsv, Json(kConfig));
  ASSERT_EQ(path.legs_in_map.size(), 2U);
  using Points = std::vector<Eigen::Vector2d>;
  EXPECT_EQ(path.legs_in_map[0], (Points{{1.5, 2}, {2.5, 2}}));
  EXPECT_EQ(path.legs_in_map[1], (Points{{2.5, 2}, {3, 2}}));
  EXPECT_EQ(path.floor, 1);
  EXPECT_EQ(path.goal_heading_rad, 0);
  EXPECT_EQ(path.robot_radius_m, 0.25);
  EXPECT_FALSE(path.may_cross_unknown);
}

TEST_F(PathIoTest, CircleAboutAPolygonAndUnknownSpace) {
  const std::string config = std::string(kConfig) + "footprint_m = [3, -4.0, 0, 1, -1, 0]\\n";
  EXPECT_EQ(Read(kCsv, Json(config)).robot_radius_m, 5);
  const PlannedPath path = Read(kCsv, Json("robot_radius_m = 1\\nunknown = \\\"costed\\\"\\n"));
  EXPECT_EQ(path.robot_radius_m, 1);
  EXPECT_TRUE(path.may_cross_unknown);
  EXPECT_EQ(path.max_hole_m, 0);
  const std::string with_holes =
      "robot_radius_m = 1\\nunknown = \\\"costed\\\"\\nmax_hole_m = 0.15";
  EXPECT_EQ(Read(kCsv, Json(with_holes)).max_hole_m, 0.15);
}

TEST_F(PathIoTest, RefusesDamagedPoints) {
  const auto expect = [&](const std::string& csv, const std::string& message) {
    NIGHTMAP_EXPECT_ERROR(DataError, Read(csv, Json(kConfig, 1)), message);
  };
  expect(kHeader, "no point");
  expect("x_m,y_m,heading_rad,distance_m\n1,2,0,0\n", "begin with");
  expect(kHeader + "1,nan,0,0,0,1\n", "y_m");
  expect(kHeader + "1,2,0\n", "path.csv:2");
  expect(kHeader + "1,2,0,0,0,1,7\n", "7 fields");
  expect(kHeader + "1,2,0,0,0,1", "truncated");
  expect(kHeader + "1,2,0,0,0,1\n1,3,1e300,1,0,1\n", "path.csv:3: heading_rad");
  expect(kHeader + "1,2,0,0,0,1\n", "path.csv: leg 0 has no length");
  expect(kHeader + "1,2,0,0,0,1\n1,3,0,1,0,1\n1,3,0,1,1,1\n", "path.csv: leg 1 has no length");
  expect(kHeader + "1,2,0,0,1,1\n", "leg_idx 1 is out of order");
  expect(kHeader + "1,2,0,0,-1,1\n", "leg_idx");
  expect(kHeader + "1,2,0,0,0,1\n1,3,0,0,1,1\n1,3,0,0,0,1\n", "path.csv:4: leg_idx 0");
}

TEST_F(PathIoTest, RefusesAnotherJson) {
  const auto expect = [&](const std::string& json, const std::string& message) {
    NIGHTMAP_EXPECT_ERROR(DataError, Read(kCsv, json), message, "path.json");
  };
  expect(Json(kConfig, 4), "make plan");
  const auto with = [](const std::string& part, const std::string& instead) {
    std::string json = Json(kConfig);
    return json.replace(json.find(part), part.size(), instead);
  };
  expect(with("1.5", "1.6"), "path.csv has 1.5");
  expect(with("legs\": 2", "legs\": 1"), "num_legs is 1");
  expect(Json("robot_radius_m = 1e300\\nunknown = \\\"allowed\\\""), "robot_radius_m");
  expect(Json(kConfig, 3, 2), "version 2");
  expect(Json(kConfig, 3, 4), "version 4");
  expect(with("floor", "level"), "floor");
  expect("{\"format\": \"other\"}", "not a planned path");
  expect("{\"format\": ", "parse");
  expect("{\"format\": \"nightmap_path\"}", "version");
  expect(Json("a = = 1"), "config");
  expect(Json("unknown = \\\"allowed\\\""), "robot_radius_m");
  expect(Json("robot_radius_m = nan\\nunknown = \\\"allowed\\\""), "robot_radius_m");
  expect(Json("robot_radius_m = 0.2"), "unknown");
  for (const std::string hole : {"-0.1", "nan", "inf", "1e300"}) {
    expect(Json("robot_radius_m = 1\\nunknown = \\\"allowed\\\"\\nmax_hole_m = " + hole),
           "max_hole_m");
  }
  for (const std::string corners : {"[0.3, nan]", "[0.3, inf]", "[0.3, \\\"x\\\"]"}) {
    expect(Json("footprint_m = " + corners + "\\nunknown = \\\"allowed\\\""), "robot_radius_m");
  }
}

}  // namespace nightmap::path_io_test
