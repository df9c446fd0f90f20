// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/objects/objects.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::objects_test {

// A corridor along x, 16 m long and 3.2 m wide, in a grid with a margin of unknown cells. Its ends
// are open, so that its straight walls have no corner.
constexpr int kWidth = 360, kHeight = 120;  // cells of 5 cm
constexpr double kCell_m = 0.05;
constexpr int kLeft = 20, kRight = 340, kLower = 20, kUpper = 84;

struct Corridor {
  Corridor() : grid{kWidth, kHeight, kCell_m, {-3, 2}, {}} {
    grid.cells.assign(static_cast<std::size_t>(kWidth) * kHeight, kUnknownCell);
    Fill({kLeft, kLower}, {kRight, kUpper}, kFreeCell);
    Fill({kLeft, kLower}, {kRight, kLower + 1}, kOccupiedCell);
    Fill({kLeft, kUpper}, {kRight, kUpper + 1}, kOccupiedCell);
  }

  void Fill(const Eigen::Vector2i& first, const Eigen::Vector2i& end, CellValue value) {
    for (int y = first.y(); y < end.y(); ++y) {
      for (int x = first.x(); x < end.x(); ++x) grid.cells[grid.Index(x, y)] = value;
    }
  }

  // The outline of a box with unknown cells in it, as a scanner sees a column.
  void Column(int x, int y, int width, int height) {
    Fill({x, y}, {x + width, y + height}, kOccupiedCell);
    Fill({x + 1, y + 1}, {x + width - 1, y + height - 1}, kUnknownCell);
  }

  // A recess of the upper wall.
  void Alcove(int x, int width, int depth) {
    Fill({x, kUpper}, {x + width, kUpper + depth}, kFreeCell);
    Fill({x - 1, kUpper}, {x, kUpper + depth + 1}, kOccupiedCell);
    Fill({x + width, kUpper}, {x + width + 1, kUpper + depth + 1}, kOccupiedCell);
    Fill({x, kUpper + depth}, {x + width, kUpper + depth + 1}, kOccupiedCell);
  }

  OccupancyGrid grid;
};

constexpr int kColumnX = 100, kColumnY = 48, kColumnWidth = 10, kColumnHeight = 6;
constexpr int kAlcoveX = 230, kAlcoveWidth = 24, kAlcoveDepth = 12;

OccupancyGrid WithColumnAndAlcove() {
  Corridor corridor;
  corridor.Column(kColumnX, kColumnY, kColumnWidth, kColumnHeight);
  corridor.Alcove(kAlcoveX, kAlcoveWidth, kAlcoveDepth);
  return corridor.grid;
}

ObjectsResult Propose(const OccupancyGrid& grid,
                      const ObjectsOptions& options = {},
                      int num_threads = 2) {
  Progress progress("test", false);
  return RunObjects(options, grid, progress, num_threads);
}

// The object that contains the middle of a box of cells; none: nullptr.
const MapObject* At(const ObjectsResult& result,
                    const OccupancyGrid& grid,
                    const Eigen::Vector2d& middle) {
  const Eigen::Vector2d point = grid.FromCells(middle);
  const auto found = std::ranges::find_if(
      result.objects, [&](const MapObject& object) { return Contains(object, point); });
  return found == result.objects.end() ? nullptr : &*found;
}

const Eigen::Vector2d kColumn(kColumnX + kColumnWidth / 2.0, kColumnY + kColumnHeight / 2.0);
const Eigen::Vector2d kAlcove(kAlcoveX + kAlcoveWidth / 2.0, kUpper + kAlcoveDepth / 2.0);

OccupancyGrid Turned(const OccupancyGrid& grid) {
  OccupancyGrid turned{grid.height, grid.width, grid.resolution_m, {0, 0}, {}};
  turned.cells.resize(grid.cells.size());
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      turned.cells[turned.Index(grid.height - 1 - y, x)] = grid.At({x, y});
    }
  }
  return turned;
}

TEST(Objects, AreTheColumnAndTheAlcoveButNoStraightWall) {
  const OccupancyGrid grid = WithColumnAndAlcove();
  const ObjectsResult result = Propose(grid);
  for (const MapObject& object : result.objects) {
    const Eigen::Vector2d cell = grid.ToCells(object.map_from_object.translation);
    EXPECT_LT(std::min((cell - kColumn).norm(), (cell - kAlcove).norm()), 40) << cell.transpose();
    EXPECT_GE(object.distinctiveness, ObjectsOptions().min_distinctiveness);
  }
  ASSERT_EQ(result.objects.size(), 2u);
  EXPECT_TRUE(At(result, grid, kColumn));
  EXPECT_TRUE(At(result, grid, kAlcove));
  EXPECT_EQ(result.objects[0].name, "object 1");
  EXPECT_EQ(result.objects[1].name, "object 2");
  EXPECT_GE(result.objects[0].distinctiveness, result.objects[1].distinctiveness);
}

TEST(Objects, AreTightBoxesAlongTheWalls) {
  const OccupancyGrid grid = WithColumnAndAlcove();
  const ObjectsResult result = Propose(grid);
  const MapObject* column = At(result, grid, kColumn);
  ASSERT_TRUE(column);
  EXPECT_NEAR(column->map_from_object.heading_rad, 0, 0.01);
  EXPECT_NEAR(column->size_m.x(), kColumnWidth * kCell_m, 0.011);
  EXPECT_NEAR(column->size_m.y(), kColumnHeight * kCell_m, 0.011);
  EXPECT_LT((column->map_from_object.translation - grid.FromCells(kColumn)).norm(), 0.011);
}

TEST(Objects, AStraightCorridorHasNone) {
  const ObjectsResult result = Propose(Corridor().grid);
  EXPECT_TRUE(result.objects.empty());
  EXPECT_EQ(DescribeObjects(result)["num_objects"], 0);
  EXPECT_FALSE(DescribeObjects(result).contains("largest_distinctiveness"));
}

TEST(Objects, AMapWithoutWallsHasNone) {
  OccupancyGrid grid = Corridor().grid;
  std::ranges::replace(grid.cells, kOccupiedCell, kFreeCell);
  EXPECT_TRUE(Propose(grid).objects.empty());
  EXPECT_TRUE(Propose({1, 1, kCell_m, {0, 0}, {kOccupiedCell}}).objects.empty());
}

TEST(Objects, TwoColumnsThatAreTheSameAreHardlyDistinctive) {
  Corridor corridor;
  corridor.Column(kColumnX, kColumnY, kColumnWidth, kColumnHeight);
  corridor.Column(kColumnX + 120, kColumnY, kColumnWidth, kColumnHeight);
  EXPECT_TRUE(Propose(corridor.grid).objects.empty());
  ObjectsOptions options;
  options.min_distinctiveness = 0;
  const ObjectsResult all = Propose(corridor.grid, options);
  const MapObject* column = At(all, corridor.grid, kColumn);
  ASSERT_TRUE(column);
  EXPECT_LT(*column->distinctiveness, 0.05);
  const ObjectsResult single = Propose(WithColumnAndAlcove(), options);
  const MapObject* alone = At(single, corridor.grid, kColumn);
  ASSERT_TRUE(alone);
  EXPECT_GT(*alone->distinctiveness, 0.25);
}

TEST(Objects, OfATurnedMapAreTheSame) {
  const OccupancyGrid grid = WithColumnAndAlcove();
  const OccupancyGrid turned = Turned(grid);
  const ObjectsResult before = Propose(grid), after = Propose(turned);
  ASSERT_EQ(before.objects.size(), after.objects.size());
  for (const MapObject& object : before.objects) {
    const Eigen::Vector2d cell = grid.ToCells(object.map_from_object.translation);
    const MapObject* same = At(after, turned, {grid.height - cell.y(), cell.x()});
    ASSERT_TRUE(same) << object.name;
    EXPECT_NEAR(*same->distinctiveness, *object.distinctiveness, 0.03);
    Eigen::Vector2d size_m = same->size_m;
    if (std::abs(std::sin(same->map_from_object.heading_rad)) < 0.5)
      std::swap(size_m.x(), size_m.y());
    EXPECT_LT((size_m - object.size_m).norm(), 0.15);
  }
}

TEST(Objects, OfAGridWithAYawTurnWithIt) {
  OccupancyGrid grid = WithColumnAndAlcove();
  const ObjectsResult before = Propose(grid);
  grid.origin_yaw_rad = 0.5;
  const ObjectsResult after = Propose(grid);
  ASSERT_EQ(before.objects.size(), after.objects.size());
  const MapObject* column = At(after, grid, kColumn);
  ASSERT_TRUE(column);
  EXPECT_NEAR(column->map_from_object.heading_rad, 0.5, 0.01);
}

TEST(Objects, DoNotDependOnTheNumberOfThreads) {
  const OccupancyGrid grid = WithColumnAndAlcove();
  ObjectsOptions options;
  options.min_distinctiveness = 0;
  options.min_distance_m = 0.1;
  const ObjectsResult one = Propose(grid, options, 1), four = Propose(grid, options, 4);
  EXPECT_GE(one.objects.size(), 2u);
  EXPECT_EQ(ObjectsToYaml(one.objects), ObjectsToYaml(four.objects));
  EXPECT_EQ(DrawObjects(grid, one.objects).pixels, DrawObjects(grid, four.objects).pixels);
}

TEST(Objects, AreAsManyAndAsLargeAsOptionsAllow) {
  const OccupancyGrid grid = WithColumnAndAlcove();
  ObjectsOptions options;
  options.max_objects = 1;
  options.max_object_size_m = 0.4;
  const ObjectsResult result = Propose(grid, options);
  ASSERT_EQ(result.objects.size(), 1u);
  EXPECT_GE(result.num_distinctive, 2u);
  ASSERT_EQ(result.notices.size(), 1u);
  EXPECT_THAT(result.notices[0], testing::StartsWith("object 'object 1' is cut from "));
  EXPECT_LE(result.objects[0].size_m.maxCoeff(), 0.4);
}

TEST(Objects, AreDrawnOnTheMap) {
  const OccupancyGrid grid = WithColumnAndAlcove();
  const auto num_reds = [](const ColorImage& image) {
    int count = 0;
    for (std::size_t i = 0; i < image.pixels.size(); i += 3) {
      count += image.pixels[i] > 150 && image.pixels[i + 1] < 100 ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(num_reds(DrawObjects(grid, {})), 0);
  EXPECT_GT(num_reds(DrawObjects(grid, Propose(grid).objects)), 200);
}

}  // namespace nightmap::objects_test
