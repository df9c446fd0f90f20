// SPDX-License-Identifier: Apache-2.0
// Ends of a path that are things, or the nearest thing of a class.

#include <nlohmann/json.hpp>
#include <numbers>

#include "stages/plan/plan/path_output.h"
#include "stages/plan/plan/plan.h"
#include "stages/plan/plan/segment.h"
#include "tests/stages/plan/plan/planning.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap::thing_ends_test {

constexpr double kRadius_m = 0.2;

Thing MakeThing(const std::string& class_name,
                int number,
                const Rigid2& map_from_thing,
                const Eigen::Vector2d& size_m) {
  Thing thing;
  thing.name = class_name + "_" + std::to_string(number);
  thing.class_name = class_name;
  thing.map_from_thing = map_from_thing;
  thing.size_m = {size_m.x(), size_m.y(), 0.8};
  return thing;
}

// Cells are of 5 cm.
void Fill(double x0_m, double y0_m, double x1_m, double y1_m, PlanInputs* inputs) {
  const auto cell = [](double m) { return static_cast<int>(std::lround(m / 0.05)); };
  FillCells(cell(x0_m), cell(y0_m), cell(x1_m), cell(y1_m), kOccupiedCell, &inputs->grid);
}

// Occupies the cells whose centres are in the thing.
void Stand(const Thing& thing, PlanInputs* inputs) {
  const EndBox box{"", thing.map_from_thing, thing.size_m.head<2>(), true};
  OccupancyGrid& grid = inputs->grid;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const bool is_in_it = box.Distance_m(grid.CenterInMap({x, y})) == 0;
      if (is_in_it) grid.cells[grid.Index(x, y)] = kOccupiedCell;
    }
  }
  inputs->things.push_back(thing);
}

// A hall of 8 m x 6 m within walls, from (0, 0) on.
PlanInputs Hall() {
  PlanInputs inputs{FreeGrid(160, 120, 0.05), {}, {}};
  FillCells(0, 0, 160, 120, kOccupiedCell, &inputs.grid);
  FillCells(2, 2, 158, 118, kFreeCell, &inputs.grid);
  return inputs;
}

// A hall with a sofa in the middle that looks to the right.
PlanInputs HallWithSofa() {
  PlanInputs inputs = Hall();
  Stand(MakeThing("sofa", 1, {0, {4, 3}}, {0.8, 2}), &inputs);
  return inputs;
}

PlanOptions Between(const std::string& start, const std::string& goal) {
  return nightmap::Between(start, goal, kRadius_m);
}

EndBox BoxOf(const Endpoint& end) { return end.request.box.value(); }

// Expectations of every end at a thing.
void ExpectBesideItsThing(const Endpoint& end, const PlanInputs& inputs) {
  EXPECT_EQ(inputs.grid.At(end.cell), kFreeCell);
  EXPECT_LE(BoxOf(end).Distance_m(end.point_in_map), 1);
  EXPECT_GE(BoxOf(end).Distance_m(end.point_in_map), kRadius_m);
}

void ExpectFaces(const PathPoint& point, const Rigid2& map_from_thing) {
  const Eigen::Vector2d way = map_from_thing.translation - point.point_in_map;
  const double off_rad = WrapAngle_rad(point.heading_rad - std::atan2(way.y(), way.x()));
  EXPECT_LT(std::abs(off_rad), 5 * std::numbers::pi / 180);
}

TEST(EndBox, DistanceAndFrontOfATurnedBox) {
  const EndBox box{"", {std::numbers::pi / 2, {1, 2}}, {2, 4}, true};  // looks up; 4 m wide
  EXPECT_EQ(box.Distance_m({2.9, 2.9}), 0);
  EXPECT_NEAR(box.Distance_m({1, 3.5}), 0.5, 1e-12);
  EXPECT_NEAR(box.Distance_m({6, 7}), 5, 1e-12);  // from the corner at (3, 3)
  EXPECT_TRUE(box.IsInFront({1, 3.1}));
  EXPECT_TRUE(box.IsInFront({3.4, 3.5}));
  EXPECT_FALSE(box.IsInFront({3.6, 3.5}));
  EXPECT_FALSE(box.IsInFront({1, 0.9}));
  EXPECT_FALSE(box.IsInFront({1, 2}));
}

TEST(ThingEnds, TheRobotStopsBeforeTheFrontAndFacesIt) {
  const PlanInputs inputs = HallWithSofa();
  for (const char* goal : {"object:sofa_1", "object:sofa"}) {
    const PlanResult result = Plan(Between("1,3", goal), inputs);
    const Endpoint& end = result.ends[1];
    ExpectBesideItsThing(end, inputs);
    ExpectFaces(result.path.back(), {0, {4, 3}});
    EXPECT_GT(end.point_in_map.x(), 4.4);
    EXPECT_NEAR(end.point_in_map.y(), 3, 0.1);
    EXPECT_EQ(result.path.back().point_in_map, end.point_in_map);
  }
}

TEST(ThingEnds, AStartBesideAThingLooksAlongThePath) {
  const PlanInputs inputs = HallWithSofa();
  const PlanResult result = Plan(Between("object:sofa", "7,5"), inputs);
  ExpectBesideItsThing(result.ends[0], inputs);
  const auto& path = result.path;
  const Eigen::Vector2d step = path[1].point_in_map - path[0].point_in_map;
  EXPECT_NEAR(path[0].heading_rad, std::atan2(step.y(), step.x()), 1e-9);
  EXPECT_EQ(path.back().heading_rad, path[path.size() - 2].heading_rad);
}

TEST(ThingEnds, OnlyTheLastGoalIsFaced) {
  const PlanInputs inputs = HallWithSofa();
  const PlanResult result = Plan(Between("1,3", "object:sofa;1,3;object:sofa"), inputs);
  ASSERT_EQ(result.legs.size(), 3U);
  EXPECT_EQ(result.ends[1].cell, result.ends[3].cell);
  ExpectFaces(result.path.back(), {0, {4, 3}});
  const std::size_t last = result.legs[0].last_point;
  const Eigen::Vector2d onward =
      result.path[last + 1].point_in_map - result.path[last].point_in_map;
  EXPECT_NEAR(result.path[last].heading_rad, std::atan2(onward.y(), onward.x()), 1e-9);
}

TEST(ThingEnds, WithABlockedFrontAnotherSideDoes) {
  PlanInputs inputs = HallWithSofa();
  Fill(4.4, 1.2, 7.9, 4.8, &inputs);
  const PlanResult result = Plan(Between("1,3", "object:sofa_1"), inputs);
  ExpectBesideItsThing(result.ends[1], inputs);
  EXPECT_LT(result.ends[1].point_in_map.x(), 3.6);  // the back is nearest to the centre
  ExpectFaces(result.path.back(), {0, {4, 3}});
}

// Free cells before the front serve nobody who cannot get there; nor does the start change rooms.
TEST(ThingEnds, AFrontBehindAWallIsNotReached) {
  PlanInputs inputs = HallWithSofa();
  Fill(4.35, 0, 4.45, 6, &inputs);
  const PlanResult result = Plan(Between("4,0.6", "object:sofa_1"), inputs);
  EXPECT_EQ(result.ends[0].moved_by_m, 0);
  EXPECT_LT(result.ends[1].point_in_map.x(), 4.4);
  ExpectBesideItsThing(result.ends[1], inputs);
}

// Under a table the grid is free, but nobody drives there.
TEST(ThingEnds, NobodyStandsInAThingThatTheGridDoesNotShow) {
  PlanInputs inputs = Hall();
  inputs.things = {MakeThing("table", 1, {1, {4, 3}}, {1, 1.5})};
  const PlanResult result = Plan(Between("1,3", "object:table_1"), inputs);
  ExpectBesideItsThing(result.ends[1], inputs);
  EXPECT_TRUE(BoxOf(result.ends[1]).IsInFront(result.ends[1].point_in_map));
}

TEST(ThingEnds, AThingOutOfReachIsRefusedWithTheRemedy) {
  PlanInputs inputs = HallWithSofa();
  Fill(2.2, 0.1, 6, 5.9, &inputs);
  ExpectError(Between("1,3", "object:sofa"),
              inputs,
              {"goal 'object:sofa' (sofa_1) at 4.000,3.000 is inside an obstacle",
               "m from its rectangle at",
               "more than snap_radius_m 1"});
  const PlanOptions wide = nightmap::Between("1,3", "object:sofa_1", kRadius_m, 2);
  EXPECT_LT(Plan(wide, inputs).ends[1].point_in_map.x(), 2.2);
  PlanInputs cut_off = HallWithSofa();
  Fill(2, 0.1, 2.2, 5.9, &cut_off);
  ExpectError(Between("1,3", "object:sofa_1"),
              cut_off,
              {"no path from start '1,3' to goal 'object:sofa_1'",
               "1.82 m from the other",
               "a larger snap_radius_m"});
}

// The next room is nearest to the sofa's centre, but from there the robot sees a wall.
TEST(ThingEnds, BehindAWallIsNotBesideTheThing) {
  PlanInputs inputs = HallWithSofa();
  Fill(3.35, 0, 3.55, 5, &inputs);    // behind the sofa
  Fill(4.4, 1.2, 7.9, 4.8, &inputs);  // before it
  const PlanResult result = Plan(Between("1,1", "object:sofa_1"), inputs);
  ExpectBesideItsThing(result.ends[1], inputs);
  EXPECT_EQ(result.ends[1].side, ThingSide::kOther);
  EXPECT_GT(result.ends[1].point_in_map.x(), 3.6);
}

// sofa_1 is behind the wall beside the start, sofa_2 farther, but in the same room.
PlanInputs TwoRooms() {
  PlanInputs inputs = Hall();
  Fill(3.9, 0, 4.1, 5, &inputs);
  Stand(MakeThing("sofa", 1, {0, {4.8, 1}}, {0.8, 1.2}), &inputs);
  Stand(MakeThing("sofa", 2, {0, {0.8, 4.5}}, {0.8, 1.2}), &inputs);
  Stand(MakeThing("lamp", 1, {0, {6, 5}}, {0.3, 0.3}), &inputs);
  return inputs;
}

TEST(ThingEnds, OfAClassTheNearestByPathIsTaken) {
  const PlanInputs inputs = TwoRooms();
  const PlanResult result = Plan(Between("3.4,1", "object:sofa"), inputs);
  EXPECT_EQ(BoxOf(result.ends[1]).name, "sofa_2");
  EXPECT_EQ(result.ends[1].request.text, "object:sofa");
  const double shortest_m = result.path.back().distance_m;
  EXPECT_LT(shortest_m, Plan(Between("3.4,1", "object:sofa_1"), inputs).path.back().distance_m);
  // From the goal before it, not from the start.
  const PlanResult two = Plan(Between("3.4,1", "object:lamp;object:sofa"), inputs);
  EXPECT_EQ(BoxOf(two.ends[2]).name, "sofa_1");
}

TEST(ThingEnds, OfAClassOneThatIsReachedIsTaken) {
  PlanInputs inputs = TwoRooms();
  Fill(3.9, 4.9, 4.1, 6, &inputs);  // closes the door
  EXPECT_EQ(BoxOf(Plan(Between("7.5,1", "object:sofa"), inputs).ends[1]).name, "sofa_1");
  EXPECT_EQ(BoxOf(Plan(Between("3.4,1", "object:sofa"), inputs).ends[1]).name, "sofa_2");
}

TEST(ThingEnds, AClassOfSeveralIsNoStart) {
  ExpectError(Between("object:sofa", "1,1"),
              TwoRooms(),
              {"start 'object:sofa' fits 2 things (sofa_1, sofa_2): name one of them"});
  EXPECT_EQ(BoxOf(Plan(Between("object:lamp", "1,1"), TwoRooms()).ends[0]).name, "lamp_1");
}

TEST(ThingEnds, UnknownNamesNameThoseAlike) {
  ExpectError(Between("1,1", "object:sofa_7"),
              TwoRooms(),
              {"object 'sofa_7' is not among the 3 of the map (sofa_1, sofa_2, lamp_1), "
               "nor a class of things (sofa, lamp)"});
  ExpectError(Between("1,1", "object:lump"), TwoRooms(), {"(lamp_1, sofa_1, sofa_2"});
}

TEST(ThingEnds, AnObjectComesBeforeAThingOfItsName) {
  PlanInputs inputs = TwoRooms();
  inputs.objects = {{"sofa", {0, {7, 1}}, {0.4, 0.4}, {}}};
  const PlanResult result = Plan(Between("3.4,1", "object:sofa"), inputs);
  EXPECT_EQ(result.ends[1].point_in_map, Eigen::Vector2d(7, 1));
}

TEST(ThingEnds, TheBottomOfAThingTellsItsFloor) {
  PlanInputs inputs = TwoRooms();
  inputs.floors.push_back({1, 3, "", "", ""});
  inputs.things[0].bottom_m = -0.15;  // measured a little low
  inputs.things[1].bottom_m = 2.9;
  inputs.things[2].bottom_m = 2.6;  // hangs from the ceiling
  const auto floor_of = [&](const std::string& start, const std::string& goal) {
    return PlanFloor(Between(start, goal), inputs);
  };
  EXPECT_EQ(floor_of("object:sofa_1", "1,1"), 0U);
  EXPECT_EQ(floor_of("object:sofa_2", "1,1,3.1"), 1U);
  EXPECT_EQ(floor_of("object:lamp", "object:sofa"), 0U);
  NIGHTMAP_EXPECT_ERROR(DataError, floor_of("1,1", "object:sofa_2"), "a path keeps to one floor");
  EXPECT_EQ(BoxOf(Plan(Between("3.4,1", "object:sofa"), inputs).ends[1]).name, "sofa_1");
  inputs.things.erase(inputs.things.begin());
  NIGHTMAP_EXPECT_ERROR(
      DataError, floor_of("1,1", "object:sofa"), "but goal 'object:sofa' (sofa_2) on");
}

TEST(ThingEnds, FilesShowTheThing) {
  const PlanInputs inputs = HallWithSofa();
  const PlanResult result = Plan(Between("1,3", "object:sofa"), inputs);
  const auto json = PathToJson(result, "");
  EXPECT_EQ(json["goal"]["request"], "object:sofa");
  EXPECT_EQ(json["goal"]["box"]["name"], "sofa_1");
  EXPECT_EQ(json["goal"]["box"]["size_y_m"], 2.0);
  EXPECT_EQ(json["goal"]["box"]["side"], "front");
  EXPECT_FALSE(json["start"].contains("box"));
  PlanResult without = result;
  without.ends[1].request.box.reset();
  EXPECT_NE(DrawPath({}, inputs, result).pixels, DrawPath({}, inputs, without).pixels);
}

// Whether the start reaches a free cell before the front that sees the thing.
bool HasFrontCell(const PlanInputs& inputs, const EndBox& box, const Eigen::Vector2i& from) {
  const CostMap map = MakeCostMap(inputs.grid, {}, kRadius_m, 1);
  const auto labels = LabelReachable(map);
  for (std::size_t i = 0; i < map.Size(); ++i) {
    if (labels[i] == 0 || labels[i] != labels[map.Index(from)]) continue;
    const Eigen::Vector2d point = inputs.grid.CenterInMap(map.Cell(i));
    const double distance_m = box.Distance_m(point);
    if (distance_m < kRadius_m || distance_m > 1 || !box.IsInFront(point)) continue;
    bool is_seen = true;
    const auto look = [&](const Eigen::Vector2i& cell, double) {
      const bool is_own = box.Distance_m(inputs.grid.CenterInMap(cell)) <= 0.1;
      is_seen = is_own || inputs.grid.At(cell) != kOccupiedCell;
      return is_seen && !is_own;
    };
    const Eigen::Vector2d centre = inputs.grid.ToCells(box.map_from_box.translation);
    VisitSegment(inputs.grid.ToCells(point), centre, look);
    if (is_seen) return true;
  }
  return false;
}

TEST(ThingEnds, RandomThingsAreReachedAtTheirFrontIfTheyCan) {
  int num_in_front = 0;
  int num_elsewhere = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    PlanInputs inputs = Hall();
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d centre(random.Uniform(2, 7.5), random.Uniform(0.5, 5.5));
      const Eigen::Vector2d size_m(random.Uniform(0.05, 1), random.Uniform(0.05, 2));
      Stand(MakeThing("box", i, {random.Uniform(-3, 3), centre}, size_m), &inputs);
    }
    const PlanResult result = Plan(Between("0.6,3", "object:box_0"), inputs);
    const Endpoint& end = result.ends[1];
    ExpectBesideItsThing(end, inputs);
    ExpectFaces(result.path.back(), inputs.things[0].map_from_thing);
    const bool is_in_front = BoxOf(end).IsInFront(end.point_in_map);
    EXPECT_EQ(is_in_front, HasFrontCell(inputs, BoxOf(end), result.ends[0].cell)) << seed;
    ++(is_in_front ? num_in_front : num_elsewhere);
  }
  EXPECT_GT(num_in_front, 20);
  EXPECT_GT(num_elsewhere, 0);
}

}  // namespace nightmap::thing_ends_test
