// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "tests/stages/dense/grid/room.h"

namespace nightmap::grid_test {

TEST(Grid, FloorAndCeilingAreNoObstacles) {
  const FloorGrid result = Project(EmptyRoom().Tree());
  EXPECT_EQ(result.num_occupied_cells, 0);
  EXPECT_EQ(result.num_free_cells, 400);
  EXPECT_EQ(result.num_ground_cells, 400);
}

TEST(Grid, WallTableAndLampBecomeWhatTheyAre) {
  VoxelRoom room = EmptyRoom();
  room.Fill({0, 0, 0}, {0, 19, 48}, true);      // wall
  room.Fill({5, 5, 14}, {8, 9, 14}, true);      // table top at 0.725 m
  room.Fill({12, 12, 40}, {14, 14, 42}, true);  // lamp above the robot
  const FloorGrid result = Project(room.Tree());
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 20; ++y) {
      const bool wall = x == 0;
      const bool table = x >= 5 && x <= 8 && y >= 5 && y <= 9;
      EXPECT_EQ(CellAt(result, x, y), wall || table ? kOccupiedCell : kFreeCell) << x << " " << y;
    }
  }
}

TEST(Grid, TheRobotsHeightDecidesWhatItPassesUnder) {
  VoxelRoom room = EmptyRoom();
  room.Fill({5, 5, 14}, {8, 9, 14}, true);  // table top, underside at 0.7 m
  GridOptions options;
  for (const double height_m : {0.3, 0.72}) {  // 0.725 m: the centre of the table's voxels
    options.robot_height_m = height_m;
    EXPECT_EQ(CellAt(Project(room.Tree(), options), 6, 7), kFreeCell) << height_m;
  }
  for (const double height_m : {0.73, 1.5, 3.0}) {  // 3 m: the room's ceiling is in the way
    options.robot_height_m = height_m;
    EXPECT_EQ(CellAt(Project(room.Tree(), options), 6, 7), kOccupiedCell) << height_m;
  }
}

TEST(Grid, NoisyFloorStaysFree) {
  Random random(3);
  OccupancyTree tree{kResolution_m, {}};
  for (int x = 0; x < 40; ++x) {
    for (int y = 0; y < 40; ++y) {
      const double z = std::clamp(0.03 * random.Gaussian(), -0.09, 0.09);
      const int key = static_cast<int>(std::floor(z / kResolution_m));
      const Eigen::Vector3d centre(x + 0.5, y + 0.5, key + 0.5);
      tree.leaves.push_back(VoxelRoom::Leaf(kResolution_m * centre, kResolution_m, true));
    }
  }
  const FloorGrid result = Project(tree);
  EXPECT_EQ(result.num_occupied_cells, 0);
  EXPECT_EQ(result.num_free_cells, 1600);
}

TEST(Grid, StepAndRobotHeightAreComparedWithCentres) {
  // Centres at 0.075 (driven over), 0.125, 1.475 (hit), 1.525 (passed under).
  const std::map<int, int> expected = {
      {1, kFreeCell}, {2, kOccupiedCell}, {29, kOccupiedCell}, {30, kFreeCell}};
  for (const auto& [z, cell] : expected) {
    VoxelRoom room = EmptyRoom();
    room.Fill({8, 8, z}, {10, 10, z}, true);
    EXPECT_EQ(CellAt(Project(room.Tree()), 9, 9), cell) << z;
  }
}

TEST(Grid, UnseenColumnsAreUnknownAndTheGridIsCropped) {
  VoxelRoom room;
  room.Fill({100, -50, -1}, {109, -41, -1}, true);   // floor
  room.Fill({300, 300, 45}, {310, 310, 45}, true);   // far ceiling only
  room.Fill({200, 200, 40}, {210, 210, 44}, false);  // free space above the robot only
  const FloorGrid result = Project(room.Tree());
  EXPECT_EQ(result.num_free_cells, 100);
  EXPECT_EQ(result.grid.width, 20);  // and 0.25 m on each side
  EXPECT_EQ(result.grid.height, 20);
  EXPECT_EQ(result.num_unknown_cells, 300);
  EXPECT_NEAR(result.grid.origin_in_map.x(), 4.75, 1e-12);
  EXPECT_NEAR(result.grid.origin_in_map.y(), -2.75, 1e-12);
  EXPECT_EQ(CellAt(result, 100, -50), kFreeCell);
  EXPECT_EQ(CellAt(result, 99, -50), kUnknownCell);
}

TEST(Grid, AnUnseenPartBetweenFreeOnesMakesACellUnknown) {
  // Floor and free space below, free space above, and in between: nothing, or a little.
  const std::map<int, int> expected = {{1, kFreeCell}, {2, kFreeCell}, {3, kUnknownCell}};
  for (const auto& [num_unseen, cell] : expected) {
    VoxelRoom room = EmptyRoom();
    room.Fill({20, 0, 0}, {29, 9, 0}, true);
    room.Fill({20, 0, 1}, {29, 9, 13}, false);
    room.Fill({20, 0, 14 + num_unseen}, {29, 9, 29}, false);
    EXPECT_EQ(CellAt(Project(room.Tree()), 25, 5), cell) << num_unseen;
    GridOptions options;
    options.max_unseen_m = 0.05 * num_unseen;
    EXPECT_EQ(CellAt(Project(room.Tree(), options), 25, 5), kFreeCell) << num_unseen;
  }
}

TEST(Grid, SpecksGoPolesAndWallsStay) {
  VoxelRoom room = EmptyRoom();
  room.Fill({3, 3, 10}, {3, 3, 11}, true);     // speck: two voxels
  room.Fill({10, 10, 2}, {10, 10, 20}, true);  // pole
  room.Fill({15, 2, 10}, {15, 9, 10}, true);   // shelf edge, one voxel high
  const FloorGrid result = Project(room.Tree());
  EXPECT_EQ(result.num_removed_specks, 1);
  EXPECT_EQ(CellAt(result, 3, 3), kFreeCell);
  EXPECT_EQ(CellAt(result, 10, 10), kOccupiedCell);
  EXPECT_EQ(CellAt(result, 15, 5), kOccupiedCell);
  GridOptions options;
  options.speck_min_neighbors = 0;
  EXPECT_EQ(CellAt(Project(room.Tree(), options), 3, 3), kOccupiedCell);
  options.min_occupied_voxels = 2;
  EXPECT_EQ(CellAt(Project(room.Tree(), options), 3, 3), kOccupiedCell);
  EXPECT_EQ(CellAt(Project(room.Tree(), options), 15, 5), kFreeCell);
}

// A tree read from a file holds merged leaves; they must give what their eight parts give.
TEST(Grid, MergedLeavesEqualTheirParts) {
  Random random(11);
  OccupancyTree merged{kResolution_m, {}};
  OccupancyTree split{kResolution_m, {}};
  for (int i = 0; i < 200; ++i) {  // disjoint blocks of 4 x 4 x 4
    const Eigen::Vector3d corner(4.0 * (i % 10) - 20, 4.0 * (i / 10 % 4) - 8, 4.0 * (i / 40) - 4);
    const bool occupied = random.Uniform() < 0.2;
    merged.leaves.push_back(VoxelRoom::Leaf(
        kResolution_m * (corner + Eigen::Vector3d(2, 2, 2)), 4 * kResolution_m, occupied));
    for (int k = 0; k < 64; ++k) {
      const Eigen::Vector3d centre =
          corner + Eigen::Vector3d(k % 4 + 0.5, k / 4 % 4 + 0.5, k / 16 + 0.5);
      split.leaves.push_back(VoxelRoom::Leaf(kResolution_m * centre, kResolution_m, occupied));
    }
  }
  const FloorGrid a = Project(merged);
  const FloorGrid b = Project(split);
  EXPECT_EQ(a.grid.origin_in_map, b.grid.origin_in_map);
  EXPECT_EQ(a.grid.cells, b.grid.cells);
  EXPECT_GT(a.num_occupied_cells, 0);
  std::reverse(split.leaves.begin(), split.leaves.end());
  EXPECT_EQ(Project(split).grid.cells, b.grid.cells);
  EXPECT_EQ(ProjectFloors(split, {}, {}, 4).floors[0].grid.cells, b.grid.cells);
}

TEST(Grid, FreeSpaceBeyondAWindowIsUnknownUnlessACameraWasThere) {
  VoxelRoom room = EmptyRoom();
  room.Fill({20, 0, 0}, {20, 19, 16}, true);    // wall below the window
  room.Fill({20, 0, 17}, {20, 19, 48}, false);  // and the pane, which depth passes
  room.Fill({21, 0, 0}, {29, 19, 48}, false);   // outside
  const Eigen::Vector3d inside(0.5, 0.5, 1.0);
  const Eigen::Vector3d outside(1.25, 0.5, 1.0);
  const FloorGrid seen = Project(room.Tree(), {}, {inside});
  EXPECT_EQ(CellAt(seen, 10, 10), kFreeCell);
  EXPECT_EQ(CellAt(seen, 20, 10), kOccupiedCell);
  EXPECT_EQ(CellAt(seen, 25, 10), kUnknownCell);
  EXPECT_EQ(seen.num_unvisited_cells, 9 * 20);
  EXPECT_EQ(CellAt(Project(room.Tree(), {}, {inside, outside}), 25, 10), kFreeCell);
  EXPECT_EQ(CellAt(Project(room.Tree()), 25, 10), kFreeCell);
  // A camera that flew by 4 m above is not on this floor.
  const Eigen::Vector3d above(1.25, 0.5, 4.0);
  EXPECT_EQ(CellAt(Project(room.Tree(), {}, {inside, above}), 25, 10), kUnknownCell);
}

TEST(Grid, RefusesWhatCannotBeProjected) {
  EXPECT_THROW(Project(OccupancyTree{kResolution_m, {}}), DataError);
  VoxelRoom ceiling;
  ceiling.Fill({0, 0, 60}, {5, 5, 60}, true);
  EXPECT_THROW(Project(ceiling.Tree()), DataError);
  GridOptions options;
  options.robot_height_m = 0.11;  // no voxel centre between 0.10 and 0.11
  EXPECT_THROW(Project(EmptyRoom().Tree(), options), UsageError);
}

TEST(Grid, OptionsSurviveToml) {
  GridOptions options;
  OptionList list = RegisterOptions(options);
  const std::string toml = list.ToToml();
  list.ParseToml(toml, "defaults");
  EXPECT_EQ(list.ToToml(), toml);
  EXPECT_THROW(list.ParseToml("margin_m = -1.0", "bad"), UsageError);
}

}  // namespace nightmap::grid_test
