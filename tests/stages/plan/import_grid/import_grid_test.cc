// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/import_grid/import_grid.h"

#include <numbers>

#include "tests/small_grids.h"
#include "tests/test_data.h"

namespace nightmap::import_grid_test {

// A corridor of 20 m x 2 m along x, free inside, from (1, 2) on.
OccupancyGrid Corridor(double yaw_rad) {
  OccupancyGrid grid = FreeGrid(200, 20, 0.1, {1, 2});
  grid.origin_yaw_rad = yaw_rad;
  return grid;
}

std::vector<StampedPose> Drive(double yaw_rad) {
  std::vector<StampedPose> poses;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d place = Corridor(yaw_rad).FromCells({5 + 1.5 * i, 10});
    poses.push_back({i, {Eigen::Quaterniond::Identity(), {place.x(), place.y(), 1.2}}});
  }
  return poses;
}

TEST(ImportGrid, TakesAMapThatHoldsTheTrajectoryAtAnyYaw) {
  for (const double yaw_rad : {0.0, 0.7, -2.0}) {
    EXPECT_NO_THROW(CheckPlace(Corridor(yaw_rad), Drive(yaw_rad), "map.yaml"));
  }
  EXPECT_NO_THROW(CheckPlace(Corridor(0), {}, "map.yaml"));
}

TEST(ImportGrid, CountsTheCellsOfAMapThatItTakes) {
  OccupancyGrid grid = Corridor(0);
  grid.cells[0] = kOccupiedCell;
  grid.cells[1] = kUnknownCell;
  const nlohmann::json report = RunImportGrid(grid);
  EXPECT_EQ(report["num_free_cells"], 3998);
  EXPECT_EQ(report["num_occupied_cells"], 1);
  EXPECT_EQ(report["resolution_m"], 0.1);
}

TEST(ImportGrid, RefusesAMapWithoutAFreeCell) {
  OccupancyGrid walls = Corridor(0);
  walls.cells.assign(4000, kOccupiedCell);
  NIGHTMAP_EXPECT_ERROR(DataError, RunImportGrid(walls), "map: no cell is free");
}

TEST(ImportGrid, WarnsOfAMapOfAPartOnly) {
  testing::internal::CaptureStdout();
  OccupancyGrid part = Corridor(0);
  part.width = 60;
  part.cells.resize(1200);
  EXPECT_NO_THROW(CheckPlace(part, Drive(0), "map.yaml"));
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              testing::HasSubstr("map.yaml: only 37 of 100 camera poses are in its free cells"));
}

TEST(ImportGrid, RefusesAMapThatIsElsewhere) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        CheckPlace(Corridor(std::numbers::pi), Drive(0), "map.yaml"),
                        "map.yaml: none of the 100 camera poses is in its free or occupied cells");
  OccupancyGrid unknown = Corridor(0);
  unknown.cells.assign(4000, kUnknownCell);
  NIGHTMAP_EXPECT_ERROR(
      DataError, CheckPlace(unknown, Drive(0), "map.yaml"), "give its origin [x, y, yaw]");
}

}  // namespace nightmap::import_grid_test
