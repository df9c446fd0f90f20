// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/floors_io.h"

#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::floors_io_test {

std::vector<FloorFiles> ThreeFloors() {
  return {{-1, -2.9, "floor_-1.yaml", "floor_-1.png", "floor_-1"},
          {0, 1.0 / 3, "map.yaml", "map.png", "floor_0"},
          {1, 3.1, "floor_1.yaml", "floor_1.png", "floor_1"}};
}

class FloorsIoTest : public testing::Test {
 protected:
  void ExpectRefused(const std::string& from, const std::string& to, const std::string& part) {
    std::string text = FloorsToJson(ThreeFloors());
    ASSERT_NE(text.find(from), std::string::npos) << from;
    WriteFile(path_, text.replace(text.find(from), from.size(), to));
    for (const std::string& named : {part, path_.string(), std::string("make map")}) {
      NIGHTMAP_EXPECT_ERROR(DataError, ReadFloors(path_), named);
    }
  }

  // Reads the grid as a stage does that was given the list.
  OccupancyGrid ReadGridOf(const FloorFiles& floor) const {
    StageContext context({"test", "", {{"grid", ""}}, {}}, {{"grid", {path_}}}, {}, "", 1);
    return ReadFloorGrid(context, "grid", floor);
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "floors.json";
};

TEST_F(FloorsIoTest, ReadsWhatWasWritten) {
  WriteFile(path_, FloorsToJson(ThreeFloors()));
  const auto floors = ReadFloors(path_);
  ASSERT_EQ(floors.size(), 3U);
  EXPECT_EQ(floors[0].number, -1);
  EXPECT_EQ(floors[1].height_m, 1.0 / 3);
  EXPECT_EQ(floors[2].yaml, "floor_1.yaml");
  EXPECT_EQ(FloorsToJson(floors), FloorsToJson(ThreeFloors()));
}

TEST_F(FloorsIoTest, RefusesWhatIsNoListOfFloors) {
  ExpectRefused("nightmap floors", "nightmap tile", "format");
  ExpectRefused("\"version\": 2", "\"version\": 1", "version 1");
  ExpectRefused("\"version\": 2", "\"version\": 3", "version 3");
  ExpectRefused("\"yaml\"", "\"yml\"", "yaml");
  ExpectRefused("\"floor_1.yaml\"", "\"\"", "yaml");
  ExpectRefused("-2.9", "\"low\"", "number");
  ExpectRefused("-2.9", "1e999", "overflow");
  ExpectRefused("-2.9", "9.9", "ascend in height_m");
  ExpectRefused("-2.9", "3.1", "ascend in height_m");
  ExpectRefused("\"number\": 1,", "\"number\": 2,", "numbers must ascend");
  ExpectRefused("\"number\": 0,", "\"number\": 4,", "number 0");
  ExpectRefused(
      "\"number\": 1,", "\"number\": 4294967297,", "number is 4294967297, not an integer in");
  ExpectRefused("\"number\": 0,", "\"number\": \"ground\",", "number");
  ExpectRefused("\n}", "", "parse error");
  std::filesystem::remove(path_);
  EXPECT_THROW(ReadFloors(path_), DataError);
}

TEST_F(FloorsIoTest, TheGridOfAFloorIsReadBesideTheList) {
  WriteFile(path_, FloorsToJson(ThreeFloors()));
  const FloorFiles upper = ReadFloors(path_)[2];
  const std::string remedy = "make it again or correct";
  NIGHTMAP_EXPECT_ERROR(DataError, ReadGridOf(upper), "floor_1.yaml: ", remedy + " floors.json");
  OccupancyGrid grid{2, 1, 0.1, {1, 2}, {kFreeCell, kOccupiedCell}};
  folder_.Write("floor_1.yaml", GridToYaml(grid, "floor_1.pgm"));
  NIGHTMAP_EXPECT_ERROR(DataError, ReadGridOf(upper), "floor_1.pgm: ", remedy + " floor_1.yaml");
  folder_.Write("floor_1.pgm", GridToPgm(grid));
  EXPECT_EQ(ReadGridOf(upper).cells, grid.cells);
}

TEST_F(FloorsIoTest, AMapOfAnotherSystemIsOneFloor) {
  OccupancyGrid grid{2, 1, 0.1, {1, 2}, {kFreeCell, kOccupiedCell}};
  path_ = folder_.Write("office.yaml", GridToYaml(grid, "office.pgm"));
  folder_.Write("office.pgm", GridToPgm(grid));
  const auto floors = ReadFloors(path_);
  ASSERT_EQ(floors.size(), 1U);
  EXPECT_EQ(floors[0].number, 0);
  EXPECT_EQ(floors[0].height_m, 0);
  EXPECT_EQ(ReadGridOf(floors[0]).cells, grid.cells);
}

TEST(FindFloor, GoesByTheNumber) {
  EXPECT_EQ(FindFloor(ThreeFloors(), -1), 0U);
  EXPECT_EQ(FindFloor(ThreeFloors(), 1), 2U);
  EXPECT_FALSE(FindFloor(ThreeFloors(), 2).has_value());
  EXPECT_EQ(FloorsText(ThreeFloors()),
            "floor -1 (z = -2.90 m), floor 0 (z = 0.33 m), floor 1 (z = 3.10 m)");
}

TEST(FloorBelow, IsTheHighestThatIsLower) {
  const auto floors = ThreeFloors();
  EXPECT_EQ(FloorBelow(floors, -5), 0U);
  EXPECT_EQ(FloorBelow(floors, -1.5), 0U);
  EXPECT_EQ(FloorBelow(floors, 1.4), 1U);
  EXPECT_EQ(FloorBelow(floors, 3.0), 1U);
  EXPECT_EQ(FloorBelow(floors, 4.3), 2U);
}

TEST(SpanText, HoldsATurnedGrid) {
  OccupancyGrid grid{40, 20, 0.1, {1, 2}, {}};
  EXPECT_EQ(SpanText(grid), "1.000,2.000 to 5.000,4.000");
  grid.origin_yaw_rad = std::acos(0.0);
  EXPECT_EQ(SpanText(grid), "-1.000,2.000 to 1.000,6.000");
}

}  // namespace nightmap::floors_io_test
