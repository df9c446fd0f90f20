// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/write_grid.h"

#include <set>

#include "pipeline/plan/floors_io.h"
#include "tests/test_data.h"

namespace nightmap::write_grid_test {

// A row of cells, so many of them free.
FloorGrid Row(double height_m, int num_free) {
  FloorGrid floor{.height_m = height_m, .grid = {5, 1, 0.1, {0, 0}, {}}};
  for (int x = 0; x < 5; ++x) floor.grid.cells.push_back(x < num_free ? kFreeCell : kOccupiedCell);
  return floor;
}

const std::vector<std::string> kAllPorts = {
    "floors=floors.json", "pgm=map.pgm", "yaml=map.yaml", "png=map.png", "distances=distances.h5"};

class WriteGridTest : public testing::Test {
 protected:
  struct NoOptions {
    void Register(OptionList&) {}
  };

  // Writes the files as the stage does.
  void Write(const GridResult& result, const std::vector<std::string>& ports = kAllPorts) {
    const StageSpec spec{"grid",
                         "",
                         {},
                         {{"floors", ""},
                          {"pgm", ""},
                          {"yaml", ""},
                          {"png", "", Arity::kOptional},
                          {"distances", "", Arity::kOptional}}};
    std::vector<std::string> arguments{"grid"};
    for (const std::string& text : ports) {
      const auto name_end = text.find('=') + 1;
      arguments.insert(
          arguments.end(),
          {"--out", text.substr(0, name_end) + (folder_ / text.substr(name_end)).string()});
    }
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    const auto body = [&](const NoOptions&, StageContext& context) { WriteGrids(result, context); };
    ASSERT_EQ(StageMain(static_cast<int>(argv.size()), argv.data(), spec, NoOptions{}, body), 0);
  }

  OccupancyGrid Read(const FloorFiles& floor) const {
    StageContext context(
        {"test", "", {{"grid", ""}}, {}}, {{"grid", {folder_ / "floors.json"}}}, {}, "", 1);
    return ReadFloorGrid(context, "grid", floor);
  }

  TemporaryFolder folder_;
};

TEST_F(WriteGridTest, FloorsAreNumberedFromTheOneAtZero) {
  const GridResult result{{Row(-2.9, 1), Row(0, 2), Row(2.8, 3), Row(5.6, 4)}, 1};
  Write(result);
  const auto floors = ReadFloors(folder_ / "floors.json");
  ASSERT_EQ(floors.size(), 4U);
  for (std::size_t i = 0; i < floors.size(); ++i) {
    const int number = static_cast<int>(i) - 1;
    EXPECT_EQ(floors[i].number, number);
    EXPECT_EQ(floors[i].height_m, result.floors[i].height_m);
    EXPECT_EQ(floors[i].yaml, number == 0 ? "map.yaml" : fmt::format("floor_{}.yaml", number));
    EXPECT_EQ(Read(floors[i]).cells, result.floors[i].grid.cells);
    EXPECT_TRUE(std::filesystem::exists(folder_ / floors[i].png));
    EXPECT_EQ(floors[i].distances, fmt::format("floor_{}", number));
  }
}

TEST_F(WriteGridTest, FilesOfTheUserStay) {
  folder_.Write("floor_plan.pdf", "the architect's");
  folder_.Write("floor_3.png/inside", "");
  Write({{Row(0, 2), Row(2.8, 3)}, 0});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "floor_plan.pdf"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "floor_3.png/inside"));
}

TEST_F(WriteGridTest, PicturesAndDistancesThatNobodyWantsAreNotMade) {
  Write({{Row(0, 2), Row(2.8, 3)}, 0}, {kAllPorts.begin(), kAllPorts.begin() + 3});
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.Path())) {
    names.insert(entry.path().filename());
  }
  EXPECT_EQ(
      names,
      (std::set<std::string>{"floors.json", "map.pgm", "map.yaml", "floor_1.pgm", "floor_1.yaml"}));
  for (const FloorFiles& floor : ReadFloors(folder_ / "floors.json")) {
    EXPECT_EQ(floor.png, "");
    EXPECT_EQ(floor.distances, "");
    EXPECT_EQ(Read(floor).width, 5);
  }
}

TEST_F(WriteGridTest, FilesOfFloorsThatAreGoneAreRemoved) {
  Write({{Row(-2.9, 1), Row(0, 2), Row(2.8, 3)}, 1});
  Write({{Row(0, 2), Row(2.8, 3)}, 0});
  EXPECT_EQ(ReadFloors(folder_ / "floors.json").size(), 2U);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "floor_1.pgm"));
  for (const char* kind : {"pgm", "yaml", "png"}) {
    EXPECT_FALSE(std::filesystem::exists(folder_ / fmt::format("floor_-1.{}", kind))) << kind;
  }
}

}  // namespace nightmap::write_grid_test
