// SPDX-License-Identifier: Apache-2.0
// Ramps, steps, drops and several floors.
#include "stages/dense/grid/floors.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/stages/dense/grid/room.h"

namespace nightmap::floors_test {

// Solid ground up to and including voxel `top`, and free space above it up to `free_top`.
void Raise(VoxelRoom& room, int x0, int y0, int x1, int y1, int top, int free_top) {
  room.Fill({x0, y0, top - 1}, {x1, y1, top}, true);
  room.Fill({x0, y0, top + 1}, {x1, y1, free_top}, false);
}

// A hall 20 cells wide (y): 2 m of level ground, a ramp that rises a voxel every 4 cells to `top`,
// and 2 m level up there. Walls along both sides, 3 m high. The ramp ends at x = 40 + 4 * top.
VoxelRoom RampHall(int top) {
  VoxelRoom room;
  const int end = 40 + 4 * top;
  for (int x = 0; x < end + 40; ++x) {
    const int height = std::clamp((x - 40) / 4 + 1, 0, top);
    Raise(room, x, 0, x, 19, height, top + 50);
  }
  for (const int y : {-1, 20}) room.Fill({0, y, 0}, {end + 39, y, top + 50}, true);
  return room;
}

TEST(GridFloors, ARampIsFreeAndItsWallsAreNot) {
  const FloorGrid floor = Project(RampHall(20).Tree());  // up to 1 m: not another floor
  for (int x = 0; x < 160; ++x) {
    EXPECT_EQ(CellAt(floor, x, 10), kFreeCell) << x;
    EXPECT_EQ(CellAt(floor, x, 0), kFreeCell) << x;
    EXPECT_EQ(CellAt(floor, x, 20), kOccupiedCell) << x;
  }
  EXPECT_GT(floor.num_ramp_cells, 100 * 20);
}

// The same hall, with the ground unseen from x0 to x1 and free space seen from two voxels above it.
VoxelRoom RampHallWithGap(int top, int x0, int x1) {
  VoxelRoom room;
  const int end = 40 + 4 * top;
  for (int x = 0; x < end + 40; ++x) {
    const int height = std::clamp((x - 40) / 4 + 1, 0, top);
    if (x < x0 || x > x1) {
      Raise(room, x, 0, x, 19, height, top + 50);
    } else {
      room.Fill({x, 0, height + 3}, {x, 19, top + 50}, false);
    }
  }
  for (const int y : {-1, 20}) room.Fill({0, y, 0}, {end + 39, y, top + 50}, true);
  return room;
}

TEST(GridFloors, ARampGoesOnBehindAMetreOfUnseenGround) {
  const FloorGrid floor = Project(RampHallWithGap(20, 80, 99).Tree());
  for (int x = 0; x < 160; ++x) EXPECT_EQ(CellAt(floor, x, 10), kFreeCell) << x;
  EXPECT_EQ(floor.num_drop_cells, 0U);
  // Not behind two metres, because anything may rise there.
  EXPECT_EQ(CellAt(Project(RampHallWithGap(20, 70, 109).Tree()), 115, 10), kOccupiedCell);
}

TEST(GridFloors, UnseenGroundBeforeAPlatformIsNoRamp) {
  VoxelRoom room;
  Raise(room, 0, 0, 39, 19, 0, 50);
  room.Fill({40, 0, 3}, {59, 19, 50}, false);
  Raise(room, 60, 0, 99, 19, 7, 50);  // 0.35 m higher, a metre on
  EXPECT_EQ(CellAt(Project(room.Tree()), 80, 10), kOccupiedCell);
}

TEST(GridFloors, WhatStandsOnARampIsAnObstacleAndWhatHangsOverItIsNot) {
  VoxelRoom room = RampHall(20);
  const int top = (100 - 40) / 4 + 1;  // of the ramp at x = 100
  room.Fill({100, 5, top + 3}, {102, 7, top + 6}, true);
  room.Fill({100, 12, top + 35}, {102, 14, top + 36}, true);  // 1.75 m above it
  const FloorGrid floor = Project(room.Tree());
  EXPECT_EQ(CellAt(floor, 101, 6), kOccupiedCell);
  EXPECT_EQ(CellAt(floor, 101, 13), kFreeCell);
}

TEST(GridFloors, TheStepThatIsClimbedIsTheOptions) {
  // A sill across the room of a height in voxels, three cells deep.
  for (const auto& [top, cell] : std::map<int, int>{{1, kFreeCell}, {3, kOccupiedCell}}) {
    VoxelRoom room = EmptyRoom();
    Raise(room, 9, 0, 11, 19, top, 48);
    EXPECT_EQ(CellAt(Project(room.Tree()), 10, 10), cell) << top;
    GridOptions options;
    options.max_step_height_m = 0.2;
    EXPECT_EQ(CellAt(Project(room.Tree(), options), 10, 10), kFreeCell) << top;
  }
}

TEST(GridFloors, APlatformWithoutARampIsAnObstacle) {
  VoxelRoom room = EmptyRoom();
  Raise(room, 20, 0, 69, 19, 6, 48);  // 2.5 m2, 0.35 m high
  const FloorGrid floor = Project(room.Tree());
  EXPECT_EQ(CellAt(floor, 21, 10), kOccupiedCell);
  EXPECT_EQ(CellAt(floor, 60, 10), kOccupiedCell);
  EXPECT_EQ(floor.num_ramp_cells, 0U);
}

TEST(GridFloors, SmallSlopesAreNoRamps) {
  VoxelRoom room = EmptyRoom();
  for (int x = 5; x <= 20; ++x) Raise(room, x, 5, x, 8, (x - 2) / 3, 48);  // a pile of 16 x 4 cells
  EXPECT_EQ(CellAt(Project(room.Tree()), 18, 6), kOccupiedCell);
  GridOptions options;
  options.min_ramp_area_m2 = 0;
  EXPECT_EQ(CellAt(Project(room.Tree(), options), 18, 6), kFreeCell);
}

// Cushions lead from the ground onto a table in steps that a robot climbs, but at 45 degrees.
TEST(GridFloors, SteepPilesAreNoRamps) {
  VoxelRoom room = EmptyRoom();
  for (int x = 5; x <= 20; ++x) Raise(room, x, 5, x, 20, std::min(x - 4, 14), 48);
  GridOptions options;
  options.min_ramp_area_m2 = 0;
  const auto grid = Project(room.Tree(), options);
  for (const int x : {12, 16, 19}) EXPECT_EQ(CellAt(grid, x, 12), kOccupiedCell) << x;
}

// A ramp from z = 0 up to 3 m, where a second floor of 4 m x 4 m lies beside and above the first.
constexpr int kUpper = 60;  // top voxel of the second floor
VoxelRoom TwoFloors() {
  VoxelRoom room = RampHall(kUpper);
  const int end = 40 + 4 * kUpper;
  for (int floor = 0; floor < 2; ++floor) {
    Raise(room, end - 40, 21, end + 39, 100, floor * kUpper, floor * kUpper + 50);
  }
  room.Fill({end + 5, 20, kUpper + 1}, {end + 24, 20, kUpper + 50}, false);  // door upstairs
  room.Fill({end + 5, 20, kUpper}, {end + 24, 20, kUpper}, true);
  room.Fill({end - 40, 21, kUpper - 4}, {end + 39, 100, kUpper - 3}, true);  // ceiling below it
  return room;
}

TEST(GridFloors, TwoFloorsGiveTwoGrids) {
  const int end = 40 + 4 * kUpper;
  const GridResult result = ProjectFloors(TwoFloors().Tree());
  ASSERT_EQ(result.floors.size(), 2U);
  EXPECT_EQ(result.main_floor_idx, 0U);
  EXPECT_EQ(result.floors[0].height_m, 0);
  EXPECT_NEAR(result.floors[1].height_m, SurfaceHeight_m(kUpper, kResolution_m), 0.05);
  for (const FloorGrid& floor : result.floors) {
    EXPECT_EQ(CellAt(floor, end + 10, 60), kFreeCell);  // the room is on both floors
    EXPECT_EQ(CellAt(floor, 160, 10), kFreeCell);       // and so is the ramp
    EXPECT_EQ(CellAt(floor, 160, 20), kOccupiedCell);   // with its walls
  }
  EXPECT_EQ(CellAt(result.floors[0], 10, 10), kFreeCell);
  EXPECT_EQ(CellAt(result.floors[1], 10, 10), kUnknownCell);  // the foot of the ramp, 3 m below
  EXPECT_EQ(CellAt(result.floors[0], end + 10, 20), kOccupiedCell);
  EXPECT_EQ(CellAt(result.floors[1], end + 10, 20), kFreeCell);  // the door
}

TEST(GridFloors, AFloorThatNoCameraWasOnIsNone) {
  const int end = 40 + 4 * kUpper;
  const Eigen::Vector3d downstairs(0.5, 0.5, 1.0);
  const Eigen::Vector3d upstairs(kResolution_m * (end + 10), 3.0, 4.0);
  EXPECT_EQ(ProjectFloors(TwoFloors().Tree(), {}, {downstairs}).floors.size(), 1U);
  EXPECT_EQ(ProjectFloors(TwoFloors().Tree(), {}, {downstairs, upstairs}).floors.size(), 2U);
}

TEST(GridFloors, TheMapsFloorIsMainEvenWithOneBelow) {
  VoxelRoom room;
  for (const int top : {0, -60}) Raise(room, 0, 0, 49, 49, top, top + 50);
  const GridResult result = ProjectFloors(room.Tree());
  ASSERT_EQ(result.floors.size(), 2U);
  EXPECT_EQ(result.main_floor_idx, 1U);
  EXPECT_LT(result.floors[0].height_m, -2.9);
}

TEST(GridFloors, WhatLiesBelowEveryFloorIsCounted) {
  VoxelRoom room = EmptyRoom();
  EXPECT_EQ(ProjectFloors(room.Tree()).below_lowest_share, 0);
  room.Fill({0, 0, -40}, {19, 19, -37}, true);  // as much as floor and ceiling, 1.8 m down
  EXPECT_NEAR(ProjectFloors(room.Tree()).below_lowest_share, 0.5, 0.01);
}

// A counter whose front was seen, and free space above, but not its top.
TEST(GridFloors, ACounterWhoseTopWasNotSeenIsNotFree) {
  for (const int top : {14, 17}) {
    VoxelRoom room = EmptyRoom();
    for (int x = 10; x <= 19; ++x) room.Erase({x, 0, -1}, {x, 19, top});
    room.Fill({10, 0, 1}, {10, 19, top}, true);
    const FloorGrid floor = Project(room.Tree());
    EXPECT_EQ(CellAt(floor, 5, 10), kFreeCell);
    EXPECT_EQ(CellAt(floor, 10, 10), kOccupiedCell);
    for (int x = 11; x < 20; ++x) EXPECT_EQ(CellAt(floor, x, 10), kUnknownCell) << x;
  }
}

TEST(GridFloors, TablesAreNoFloors) {
  VoxelRoom room;
  Raise(room, 0, 0, 99, 49, 0, 50);
  Raise(room, 0, 50, 99, 99, 14, 50);  // 12.5 m2 of tables
  EXPECT_EQ(ProjectFloors(room.Tree()).floors.size(), 1U);
}

TEST(GridFloors, WhereTheGroundEndsIsAnObstacle) {
  VoxelRoom room = EmptyRoom();
  room.Fill({20, 0, -30}, {29, 19, 48}, false);  // a stairwell: free 1.5 m down
  const FloorGrid floor = Project(room.Tree());
  for (int y = 0; y < 20; ++y) {
    EXPECT_EQ(CellAt(floor, 19, y), kFreeCell);
    EXPECT_EQ(CellAt(floor, 20, y), kOccupiedCell);
    EXPECT_EQ(CellAt(floor, 25, y), kUnknownCell);
  }
  EXPECT_EQ(floor.num_drop_cells, 20U);
}

TEST(GridFloors, TheRoomBelowAnUnseenFloorIsNoDrop) {
  VoxelRoom room = EmptyRoom();
  room.Fill({20, 0, 1}, {29, 19, 48}, false);  // the floor was not seen here
  room.Fill({20, 0, -7}, {29, 19, -6}, true);  // but the ceiling of the room below
  room.Fill({20, 0, -50}, {29, 19, -8}, false);
  EXPECT_EQ(CellAt(Project(room.Tree()), 25, 10), kFreeCell);
}

TEST(GridFloors, ALowerFloorThatIsSeenIsADropAndALittleUnseenDepthIsNot) {
  for (const bool is_seen : {true, false}) {
    VoxelRoom room = EmptyRoom();
    room.Fill({20, 0, -4}, {29, 19, 48}, false);  // 0.2 m deep
    if (is_seen) room.Fill({20, 0, -5}, {29, 19, -5}, true);
    EXPECT_EQ(CellAt(Project(room.Tree()), 20, 10), is_seen ? kOccupiedCell : kFreeCell);
  }
}

}  // namespace nightmap::floors_test
