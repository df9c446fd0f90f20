// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/floors_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

namespace nightmap {
namespace {

std::vector<FloorFiles> ThreeFloors() {
  return {{-2.9, false, "floor_0.yaml", "floor_0.png", "floor_0"},
          {1.0 / 3, true, "map.yaml", "map.png", "floor_1"},
          {3.1, false, "floor_2.yaml", "floor_2.png", "floor_2"}};
}

class FloorsIoTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            fmt::format("nightmap_floors_{}_{}.json", info->name(), getpid());
  }
  void TearDown() override { std::filesystem::remove(path_); }

  void ExpectRefused(const std::string& from, const std::string& to, const std::string& part) {
    std::string text = FloorsToJson(ThreeFloors());
    ASSERT_NE(text.find(from), std::string::npos) << from;
    WriteFile(path_, text.replace(text.find(from), from.size(), to));
    try {
      ReadFloors(path_);
      FAIL() << "no error; wanted: " << part;
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(part));
      EXPECT_THAT(error.what(), testing::HasSubstr(path_.string()));
    }
  }

  std::filesystem::path path_;
};

TEST_F(FloorsIoTest, ReadsWhatWasWritten) {
  WriteFile(path_, FloorsToJson(ThreeFloors()));
  const auto floors = ReadFloors(path_);
  ASSERT_EQ(floors.size(), 3U);
  EXPECT_EQ(floors[1].height_m, 1.0 / 3);
  EXPECT_TRUE(floors[1].is_main);
  EXPECT_EQ(floors[2].yaml, "floor_2.yaml");
  EXPECT_EQ(FloorsToJson(floors), FloorsToJson(ThreeFloors()));
}

TEST_F(FloorsIoTest, RefusesWhatIsNoListOfFloors) {
  ExpectRefused("nightmap floors", "nightmap tile", "format");
  ExpectRefused("\"version\": 1", "\"version\": 2", "newer");
  ExpectRefused("\"yaml\"", "\"yml\"", "yaml");
  ExpectRefused("-2.9", "\"low\"", "number");
  ExpectRefused("-2.9", "9.9", "ascend");
  ExpectRefused("true", "false", "main");
  ExpectRefused("false", "true", "main");
  ExpectRefused("\n}", "", "parse error");
  std::filesystem::remove(path_);
  EXPECT_THROW(ReadFloors(path_), DataError);
}

TEST(FloorBelow, IsTheHighestThatIsLower) {
  const auto floors = ThreeFloors();
  EXPECT_EQ(FloorBelow(floors, -5), 0U);
  EXPECT_EQ(FloorBelow(floors, -1.5), 0U);
  EXPECT_EQ(FloorBelow(floors, 1.4), 1U);
  EXPECT_EQ(FloorBelow(floors, 3.0), 1U);
  EXPECT_EQ(FloorBelow(floors, 4.3), 2U);
}

}  // namespace
}  // namespace nightmap
