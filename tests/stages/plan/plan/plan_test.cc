// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/plan.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <sstream>

#include "pipeline/plan/unknown_holes.h"
#include "stages/plan/plan/path_output.h"
#include "tests/stages/plan/plan/planning.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap::plan_test {

using testing::HasSubstr;

PlanOptions Between(const std::string& start, const std::string& goal, double snap_radius_m = 1) {
  return nightmap::Between(start, goal, 0.1, snap_radius_m);
}

double TotalLength_m(const PlanResult& result) { return result.path.back().distance_m; }

// Cells of 0.1 m from (1, 2) to (3, 2.8): two rooms joined by a door of four cells, a closed cell
// on the right, an unknown corner.
PlanInputs Rooms() {
  return {GridFromText({"####################",
                        "#....#........#....#",
                        "#....#........#....#",
                        "#.............#....#",
                        "#.............#....#",
                        "#.............#....#",
                        "#....#........####.#",
                        "#....#..........????",
                        "####################"}),
          {},
          {}};
}

PlanInputs RoomsWithPictures() {
  PlanInputs inputs = Rooms();
  const QueryResult lost = Lost("site/color/lost.png", "too_few_inliers");
  inputs.queries = {lost,
                    Located("site/color/a.png", 1.25, 2.45),
                    Located("site/color/b.jpg", 2.15, 2.45),
                    Located("other/a.jpg", 1.35, 2.25),
                    Located("site/in_wall.png", 2.45, 2.65),
                    Located("site/closed.png", 2.65, 2.55),
                    lost};
  return inputs;
}

// map_server's origin may have a yaw: the same rooms, rotated in the map.
TEST(Plan, FollowsAGridThatIsTurned) {
  PlanInputs inputs = Rooms();
  PlanOptions options = Between("", "");
  const auto plan = [&](const Eigen::Rotation2Dd& turn) {
    options.start = TextOf(turn * Eigen::Vector2d(1.27, 2.23));
    options.goal = TextOf(turn * Eigen::Vector2d(2.21, 2.61));
    inputs.grid.origin_in_map = turn * Rooms().grid.origin_in_map;
    inputs.grid.origin_yaw_rad = turn.angle();
    return Plan(options, inputs);
  };
  const auto straight = plan(Eigen::Rotation2Dd(0));
  EXPECT_GT(straight.path.size(), 10);
  for (const double yaw_rad : {0.4, -2.0}) {
    const Eigen::Rotation2Dd turn(yaw_rad);
    const auto turned = plan(turn);
    EXPECT_NEAR(TotalLength_m(turned), TotalLength_m(straight), 1e-6);
    ASSERT_EQ(turned.path.size(), straight.path.size());
    for (std::size_t i = 0; i < turned.path.size(); ++i) {
      const Eigen::Vector2d expected = turn * straight.path[i].point_in_map;
      EXPECT_LT((turned.path[i].point_in_map - expected).norm(), 1e-6) << i;
    }
    options.goal = TextOf(turn * Eigen::Vector2d(0.9, 2.5));  // outside
    EXPECT_THROW(Plan(options, inputs), DataError);
  }
}

TEST(Plan, GoesThroughTheDoor) {
  const PlanResult result = Plan(Between("1.25,2.2", "2.2,2.65"), Rooms());
  EXPECT_EQ(result.path.front().point_in_map, Eigen::Vector2d(1.25, 2.2));
  EXPECT_LT((result.path.back().point_in_map - Eigen::Vector2d(2.2, 2.65)).norm(), 1e-12);
  EXPECT_GE(TotalLength_m(result), std::hypot(0.95, 0.45));
  EXPECT_LT(TotalLength_m(result), 1.4);
  EXPECT_GE(result.legs[0].min_clearance_m, 0.1 - 1e-9);
  for (std::size_t i = 1; i < result.path.size(); ++i) {
    const PathPoint& from = result.path[i - 1];
    const PathPoint& to = result.path[i];
    const Eigen::Vector2d step = to.point_in_map - from.point_in_map;
    EXPECT_LE(step.norm(), 0.1 + 1e-9);
    EXPECT_NEAR(to.distance_m - from.distance_m, step.norm(), 1e-12);
    EXPECT_NEAR(std::cos(from.heading_rad) * step.norm(), step.x(), 1e-12);
    EXPECT_NEAR(std::sin(from.heading_rad) * step.norm(), step.y(), 1e-12);
  }
}

TEST(Plan, PathsOfRandomMapsKeepTheRadius) {
  int num_found = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    PlanInputs inputs{RandomGrid(random, 40, 30, 0.03, 0.01), {}, {}};
    PlanOptions options;
    options.footprint.robot_radius_m = random.Uniform(0, 0.12);
    options.cost.clearance_m = 0.3;
    options.shorten = seed % 4 != 0;
    const OccupancyGrid grid = WithHolesFree(inputs.grid, options.cost.max_hole_m);
    const CostMap map = MakeCostMap(grid, options.cost, options.footprint.robot_radius_m, 1);
    const auto text = [&] { return TextOf(grid.CenterInMap(RandomFreeCell(random, map))); };
    options.start = text();
    options.goal = text();
    try {
      const PlanResult result = Plan(options, inputs);
      ++num_found;
      for (const PathPoint& point : result.path) {
        const Eigen::Vector2i cell = inputs.grid.CellOf(point.point_in_map);
        EXPECT_GE(map.Clearance_m(cell), options.footprint.robot_radius_m - 1e-9);
        EXPECT_GE(map.Clearance_m(cell), result.legs[0].min_clearance_m - 1e-9);
      }
    } catch (const DataError& error) {
      const bool is_same = options.start == options.goal;
      EXPECT_THAT(error.what(), HasSubstr(is_same ? "same place" : "no path"));
    }
  }
  EXPECT_GT(num_found, 100);
}

TEST(Plan, WeightKeepsAwayFromWalls) {
  PlanInputs inputs{FreeGrid(60, 60, 0.05), {}, {}};
  FillCells(20, 0, 40, 30, kOccupiedCell, &inputs.grid);  // in the middle, passed on its upper side
  PlanOptions options;
  options.start = "0.4,1.2";
  options.goal = "2.6,1.2";
  options.cost = {.clearance_weight = 0, .margin_m = 0};
  const PlanResult shortest = Plan(options, inputs);
  options.cost.clearance_weight = 10;
  const PlanResult safer = Plan(options, inputs);
  EXPECT_LT(TotalLength_m(shortest), TotalLength_m(safer));
  EXPECT_LT(shortest.legs[0].min_clearance_m + 0.1, safer.legs[0].min_clearance_m);
}

TEST(Plan, SameAtAnyNumberOfThreads) {
  Random random(4);
  PlanInputs inputs{Building(random, 300, 60), {}, {}};
  const PlanOptions options = Between("picture:start", "picture:goal");
  inputs.queries = {Located("start", 1.1, 1.1), Located("goal", 13, 13)};
  EXPECT_EQ(PathToCsv(Plan(options, inputs, 1)), PathToCsv(Plan(options, inputs, 4)));
}

TEST(Plan, PicturesAreFoundByPathItsEndOrStem) {
  PlanInputs inputs = RoomsWithPictures();
  inputs.queries[1].color_path = "../../site/color/a.png";
  for (const char* name : {"../../site/color/a.png",
                           "site/color/a.png",
                           "/site/color/a.png",
                           "../site/color/./a.png",
                           "color/a.png",
                           "a.png"}) {
    const PlanResult result = Plan(Between(std::string("picture:") + name, "picture:b"), inputs);
    EXPECT_EQ(result.ends[0].point_in_map, Eigen::Vector2d(1.25, 2.45)) << name;
    EXPECT_EQ(result.ends[1].point_in_map, Eigen::Vector2d(2.15, 2.45)) << name;
    EXPECT_EQ(result.ends[0].moved_by_m, 0);
  }
}

TEST(Plan, EmptyEndsAreFirstAndLastLocated) {
  PlanInputs inputs = RoomsWithPictures();
  inputs.queries.erase(inputs.queries.begin() + 4, inputs.queries.end() - 1);
  const PlanResult result = Plan(Between("", ""), inputs);
  EXPECT_EQ(result.ends[0].request.text, "picture:site/color/a.png");
  EXPECT_EQ(result.ends[1].request.text, "picture:other/a.jpg");
}

TEST(Plan, EmptyEndsFallBackToTheTrajectory) {
  PlanInputs inputs = Rooms();
  ExpectError<UsageError>(Between("", ""), inputs, {"option start is empty"});
  inputs.trajectory.resize(2);
  inputs.trajectory[0].pose.translation = {1.25, 2.45, 1};
  inputs.trajectory[1].pose.translation = {2.15, 2.45, 1};
  const PlanResult result = Plan(Between("", ""), inputs);
  EXPECT_EQ(result.ends[1].point_in_map, Eigen::Vector2d(2.15, 2.45));
  EXPECT_THAT(result.ends[0].request.text, HasSubstr("trajectory"));
}

// Pictures are at z = 1.2.
PlanInputs TwoFloorsWithPictures() {
  PlanInputs inputs = RoomsWithPictures();
  inputs.floors = {{-1, -3.2, "floor_-1.yaml", "", ""},
                   {0, 0, "map.yaml", "", ""},
                   {1, 2.9, "floor_1.yaml", "", ""}};
  inputs.queries[2].map_from_camera.translation.z() = 4.1;  // b.jpg
  return inputs;
}

int FloorFor(const std::string& start, const std::string& goal, int floor = 0) {
  const PlanInputs inputs = TwoFloorsWithPictures();
  PlanOptions options = Between(start, goal);
  options.floor = floor;
  return inputs.floors[PlanFloor(options, inputs)].number;
}

TEST(PlanFloor, IsThatOfTheEnds) {
  EXPECT_EQ(FloorFor("picture:color/a.png", "1,2"), 0);
  EXPECT_EQ(FloorFor("picture:b", "picture:b"), 1);
  EXPECT_EQ(FloorFor("1,2", "1,2; 2,2"), 0);
  EXPECT_EQ(FloorFor("1,2", "1,2; 2,2", -1), -1);
  EXPECT_EQ(FloorFor("picture:b", "1,2; 1.5,2", 1), 1);
  EXPECT_EQ(FloorFor("1,2,4.2", "1,2,2.9; picture:b"), 1);
  EXPECT_EQ(FloorFor("picture:b", "picture:b", 7), 1);  // asks for no floor
}

// Includes points between floors, and heights that were read rounded.
TEST(PlanFloor, OfAZIsTheOneBelow) {
  for (const auto& [z, number] :
       {std::pair("2.5", 0), {"2.81", 1}, {"5.3", 1}, {"-0.05", 0}, {"-0.8", -1}, {"-3.25", -1}}) {
    const std::string end = std::string("1,2,") + z;
    EXPECT_EQ(FloorFor(end, end), number) << z;
  }
  for (const char* z : {"2.79", "-0.2", "5.5", "90", "-3.4", "-1e300"}) {
    const std::string end = std::string("1,2,") + z;
    NIGHTMAP_EXPECT_ERROR(
        DataError, FloorFor("1,2", end), "goal '" + end + "'", "floor 1 (z = 2.90 m)");
  }
  // A picture may be from any height: of a drone, or half way up the stairs.
  PlanInputs inputs = TwoFloorsWithPictures();
  for (const auto& [z, number] : {std::pair(90.0, 1), {2.7, 0}, {-9.0, -1}}) {
    inputs.queries[2].map_from_camera.translation.z() = z;
    EXPECT_EQ(inputs.floors[PlanFloor(Between("picture:b", "picture:b"), inputs)].number, number);
  }
}

TEST(PlanFloor, IsOneForAllEnds) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        FloorFor("picture:color/a.png", "1,2; picture:b"),
                        "start 'picture:color/a.png'",
                        "floor 0 (z = 0.00 m)",
                        "goal 2 'picture:b'",
                        "floor 1 (z = 2.90 m)");
  NIGHTMAP_EXPECT_ERROR(DataError, FloorFor("picture:b", "1,2"), "the option floor says");
  NIGHTMAP_EXPECT_ERROR(
      UsageError, FloorFor("1,2", "picture:b", 2), "option floor is 2", "floor -1 (z = -3.20 m)");
}

// The first and the last pose of the camera are ends, too.
TEST(PlanFloor, OfTheTrajectory) {
  PlanInputs inputs = TwoFloorsWithPictures();
  inputs.queries.clear();
  inputs.trajectory.resize(2);
  inputs.trajectory[0].pose.translation = {1.25, 2.45, 4.1};
  inputs.trajectory[1].pose.translation = {2.15, 2.45, 4.2};
  EXPECT_EQ(PlanFloor(Between("", ""), inputs), 2U);
  inputs.trajectory[1].pose.translation.z() = 1;
  EXPECT_THROW(PlanFloor(Between("", ""), inputs), DataError);
}

// The place where a picture was taken, or a point, in a closed cell where the robot fits; the
// nearest place that the other end can reach is used.
TEST(Plan, AnEndInAClosedPocketMovesOutOfIt) {
  for (const auto& [start, goal, closed] : {std::tuple("picture:closed", "picture:b", 0U),
                                            {"1.25,2.45", "picture:closed", 1U},
                                            {"1.25,2.45", "2.65,2.55", 1U}}) {
    const PlanResult result = Plan(Between(start, goal), RoomsWithPictures());
    EXPECT_GT(result.ends[closed].moved_by_m, 0.2);
    EXPECT_LT(result.ends[closed].point_in_map.x(), 2.4);
    EXPECT_EQ(result.ends[1 - closed].moved_by_m, 0);
    ExpectError(Between(start, goal, 0.2), RoomsWithPictures(), {"no path", "snap_radius_m"});
  }
}

TEST(PlanErrors, MalformedEnds) {
  for (const char* text : {"1.2",
                           "1.2,",
                           ",2",
                           "a,b",
                           "1,2,",
                           "1,2,3,4",
                           "1,2,z",
                           "nan,2",
                           "1,inf",
                           "picture:",
                           "photo:a",
                           "1.2;2.2",
                           "1e999,0"}) {
    ExpectError<UsageError>(Between(text, "1.25,2.45"), Rooms(), {"option start"});
    ExpectError<UsageError>(Between("1.25,2.45", text), Rooms(), {"option goal"});
  }
}

// The place that is offered lies within the bounds that the same message gives.
TEST(PlanErrors, ATurnedMapNamesItsTrueBounds) {
  PlanInputs inputs = Rooms();
  inputs.grid.origin_yaw_rad = 2;
  std::string text;
  try {
    Plan(Between(TextOf(inputs.grid.FromCells({2.5, 4.5})), "99,99"), inputs);
  } catch (const DataError& error) {
    text = error.what();
  }
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0, x = 0, y = 0;
  ASSERT_EQ(std::sscanf(
                text.c_str() + text.find("spans"), "spans %lf,%lf to %lf,%lf", &x0, &y0, &x1, &y1),
            4)
      << text;
  ASSERT_EQ(std::sscanf(text.c_str() + text.find("at \""), "at \"%lf,%lf", &x, &y), 2) << text;
  EXPECT_TRUE(x0 < x && x < x1 && y0 < y && y < y1) << text;
}

TEST(PlanErrors, UnusableEnds) {
  const auto expect = [](const std::string& goal, const std::vector<std::string>& parts) {
    ExpectError(Between("1.25,2.45", goal, 0), Rooms(), parts);
  };
  expect("9,9", {"goal '9,9'", "outside of the map", "nearest free cell"});
  expect("1e200,-1e200", {"at 1e+200,-1e+200 is outside of the map"});
  expect("1.55,2.25", {"inside an obstacle"});
  expect("2.75,2.15", {"unknown space"});
  expect("1.15,2.25", {"the robot's radius 0.1", "nearest free cell is 0.1"});
  ExpectError(nightmap::Between("1.25,2.45", "1.45,2.25", 4), Rooms(), {"no cell that is free"});
}

TEST(Plan, AnEndThatMovesTakesAPlaceWithRoom) {
  PlanOptions options = Between("1.25,2.45", "2.45,2.65");
  options.cost.margin_m = 0.05;
  const PlanResult result = Plan(options, Rooms());
  EXPECT_GT(result.ends[1].moved_by_m, 0.2);
  EXPECT_LT(result.ends[1].moved_by_m, 0.35);
  EXPECT_GE(result.path.back().clearance_m, options.footprint.robot_radius_m + 0.05 - 1e-9);
  EXPECT_EQ(result.ends[0].moved_by_m, 0);
  options.cost.margin_m = 0.25;  // nowhere so much room
  EXPECT_NEAR(Plan(options, Rooms()).ends[1].moved_by_m, 0.2, 1e-9);
}

// A point where the robot does not fit moves as a picture does.
TEST(Plan, AnEndInAnObstacleMovesToTheNearestFreeCell) {
  for (const char* in_wall : {"2.45,2.65", "picture:in_wall"}) {
    PlanOptions options = Between("1.25,2.45", in_wall);
    options.cost.margin_m = 0;
    const PlanResult result = Plan(options, RoomsWithPictures());
    EXPECT_NEAR(result.ends[1].moved_by_m, 0.2, 1e-9);
    EXPECT_LT((result.ends[1].point_in_map - Eigen::Vector2d(2.25, 2.65)).norm(), 1e-9);
    EXPECT_EQ(result.ends[0].moved_by_m, 0);
    const std::vector<std::string> parts = {
        "inside an obstacle", "nearest free cell is 0.20 m away", "snap_radius_m 0.15"};
    ExpectError(Between("1.25,2.45", in_wall, 0.15), RoomsWithPictures(), parts);
    ExpectError(Between(in_wall, "1.25,2.45", 0.15), RoomsWithPictures(), parts);
    ExpectError(Between(in_wall, "1.25,2.45", 0.15), RoomsWithPictures(), {"start"});
  }
}

// A pocket of one cell is nearer to both ends than the room, but joins nothing.
TEST(Plan, EndsDoNotBecomeOneCell) {
  const PlanInputs inputs{
      GridFromText(
          {"##########", "###.######", "##########", "##########", "#........#", "##########"}),
      {},
      {}};
  const auto options = [](double snap_radius_m) {  // beside the pocket, in the wall
    return nightmap::Between("1.25,2.45", "1.45,2.45", 0, snap_radius_m);
  };
  const PlanResult result = Plan(options(1), inputs);
  EXPECT_GT(TotalLength_m(result), 0.1);
  for (const Endpoint& end : result.ends) EXPECT_NEAR(end.point_in_map.y(), 2.15, 1e-9);
  ExpectError(options(0.15),
              inputs,
              {"start '1.25,2.45' and goal '1.45,2.45' are the same place", "farther apart"});
}

// A pocket of a few cells, in which nothing can drive, is nearer to both ends than the room.
TEST(Plan, EndsMoveIntoTheRoomAndNotIntoAGap) {
  PlanInputs inputs{FreeGrid(200, 100, 0.05), {}, {}};
  FillCells(40, 40, 160, 60, kOccupiedCell, &inputs.grid);
  FillCells(95, 45, 106, 55, kFreeCell, &inputs.grid);  // two rows of cells to a robot of 0.2 m
  const PlanResult result = Plan(nightmap::Between("4.5,2.5", "5.5,2.5", 0.2, 10), inputs);
  EXPECT_GT(TotalLength_m(result), 0.5);
  for (const Endpoint& end : result.ends) EXPECT_GT(std::abs(end.point_in_map.y() - 2.5), 0.5);
}

TEST(PlanErrors, TheSamePlaceTwice) {
  ExpectError(Between("1.25,2.45", "1.25,2.45"),
              Rooms(),
              {"start '1.25,2.45' and goal '1.25,2.45' are the same place"});
  ExpectError(Between("1.25,2.45", "2.2,2.65; 2.2,2.65"),
              Rooms(),
              {"goal 1 '2.2,2.65' and goal 2 '2.2,2.65' are the same place"});
  EXPECT_EQ(Plan(Between("1.25,2.45", "2.2,2.65; 1.25,2.45"), Rooms()).legs.size(), 2U);
}

constexpr double kNoPlace_m = 1e9;

// The least sum of moves into a part of the map where the ends are two cells, found by looking at
// every cell.
double LeastMoves_m(const OccupancyGrid& grid,
                    const CostMap& map,
                    const std::array<Eigen::Vector2d, 2>& ends,
                    double radius_m) {
  struct Near {
    double move_m = kNoPlace_m;
    Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  };
  const auto labels = LabelReachable(map);
  std::map<std::int32_t, std::array<Near, 2>> nearest;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == 0) continue;
    const Eigen::Vector2i cell = map.Cell(i);
    for (std::size_t k = 0; k < 2; ++k) {
      const bool is_own = cell == grid.CellOf(ends[k]);
      const double move_m = is_own ? 0 : (grid.CenterInMap(cell) - ends[k]).norm();
      Near& best = nearest[labels[i]][k];
      if (move_m < best.move_m) best = {move_m, cell};
    }
  }
  double least_m = kNoPlace_m;
  for (const auto& [label, near] : nearest) {
    const double sum_m = near[0].move_m + near[1].move_m;
    if (near[0].cell == near[1].cell && sum_m > 0) continue;
    if (std::max(near[0].move_m, near[1].move_m) <= radius_m) least_m = std::min(least_m, sum_m);
  }
  return least_m;
}

TEST(Plan, RandomEndsMoveLeast) {
  int num_moved = 0;
  int num_refused = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Random random(seed);
    const PlanInputs inputs{RandomGrid(random, 25, 20, 0.45), {}, {}};
    const auto draw = [&] {
      return Eigen::Vector2d(random.Uniform(0.05, 1.2), random.Uniform(0.05, 0.95));
    };
    const Eigen::Vector2d start = draw();
    const Eigen::Vector2d goal = draw();
    PlanOptions options = nightmap::Between(TextOf(start), TextOf(goal), 0, random.Uniform(0, 0.5));
    options.cost.margin_m = 0;
    const CostMap map = MakeCostMap(inputs.grid, options.cost, 0, 1);
    const double least_m = LeastMoves_m(inputs.grid, map, {start, goal}, options.snap_radius_m);
    SCOPED_TRACE(seed);
    if (least_m == kNoPlace_m) {
      ++num_refused;
      EXPECT_THROW(Plan(options, inputs), DataError);
      continue;
    }
    const PlanResult result = Plan(options, inputs);
    EXPECT_NEAR(result.ends[0].moved_by_m + result.ends[1].moved_by_m, least_m, 1e-9);
    EXPECT_GT(TotalLength_m(result), 0);
    num_moved += least_m > 0 ? 1 : 0;
  }
  EXPECT_GT(num_moved, 100);
  EXPECT_GT(num_refused, 50);
}

TEST(Plan, VisitsSeveralGoalsInOrder) {
  const std::vector<std::string> goals = {"2.2,2.65", "1.25,2.2", "picture:b"};
  PlanOptions options = Between("1.25,2.45", goals[0] + "; " + goals[1] + " ;" + goals[2]);
  const PlanResult result = Plan(options, RoomsWithPictures());
  ASSERT_EQ(result.legs.size(), 3U);
  ASSERT_EQ(result.ends.size(), 4U);
  double length_m = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const PlanLeg& leg = result.legs[i];
    EXPECT_EQ(result.ends[i + 1].request.text, goals[i]);
    EXPECT_EQ(leg.first_point, i == 0 ? 0 : result.legs[i - 1].last_point);
    EXPECT_LT((result.path[leg.last_point].point_in_map - result.ends[i + 1].point_in_map).norm(),
              1e-9);
    EXPECT_EQ(result.path[leg.last_point].leg_idx, static_cast<int>(i));
    length_m += leg.length_m;
    // As long as the leg alone.
    options.start = i == 0 ? "1.25,2.45" : goals[i - 1];
    options.goal = goals[i];
    EXPECT_NEAR(TotalLength_m(Plan(options, RoomsWithPictures())), leg.length_m, 1e-9);
  }
  EXPECT_EQ(result.legs.back().last_point + 1, result.path.size());
  EXPECT_NEAR(TotalLength_m(result), length_m, 1e-9);
  for (std::size_t i = 1; i < result.path.size(); ++i) {
    EXPECT_GT(result.path[i].distance_m, result.path[i - 1].distance_m);  // no point twice
  }
  const auto json = PathToJson(result, "");
  EXPECT_EQ(json.at("num_legs"), 3);
  EXPECT_NEAR(json.at("length_m"), length_m, 1e-9);
  EXPECT_EQ(json.at("legs").at(2).at("goal").at("request"), "picture:b");
}

TEST(PlanErrors, SeveralGoals) {
  ExpectError<UsageError>(Between("1.25,2.45", "2.2,2.65;"), Rooms(), {"option goal is ''"});
  ExpectError(Between("1.25,2.45", "2.2,2.65; 2.65,2.55", 0),
              Rooms(),
              {"no path from goal 1 '2.2,2.65' to goal 2 '2.65,2.55'"});
}

// The circle about a polygon is what the path keeps clear, however the robot turns on it.
TEST(Plan, PolygonsKeepClearAtEveryHeading) {
  Random random(3);
  const PlanInputs inputs{RandomGrid(random, 120, 100, 0.004), {}, {}};
  PlanOptions options = Between("0.6,0.6", "5.4,4.4");
  options.footprint.footprint_m = {0.3, 0.15, -0.2, 0.15, -0.2, -0.15, 0.3, -0.15};
  EXPECT_NEAR(CircumscribedRadius_m(options.footprint), std::hypot(0.3, 0.15), 1e-12);
  const PlanResult result = Plan(options, inputs);
  int num_samples = 0;
  for (const PathPoint& point : result.path) {
    for (int i = 0; i < 16; ++i) {  // points of the outline, at every heading
      const Eigen::Rotation2Dd turn(point.heading_rad + i * std::numbers::pi / 8);
      for (const Eigen::Vector2d& corner : FootprintCorners(options.footprint)) {
        for (const double share : {1.0, 0.7, 0.3}) {
          const Eigen::Vector2d at = point.point_in_map + turn * (share * corner);
          EXPECT_EQ(inputs.grid.At(inputs.grid.CellOf(at)), kFreeCell);
          ++num_samples;
        }
      }
    }
  }
  EXPECT_GT(num_samples, 20000);
  PlanOptions round = options;
  round.footprint = {std::hypot(0.3, 0.15), {}};
  EXPECT_EQ(PathToCsv(Plan(round, inputs)), PathToCsv(result));
  for (const std::vector<double>& broken :
       {std::vector<double>{1}, {1, 2}, {1, 2, 3, 4}, {1, 2, 3, 4, 5}}) {
    options.footprint.footprint_m = broken;
    ExpectError<UsageError>(options, inputs, {"option footprint_m"});
  }
}

// A detour round unknown space, or through it, as it is costed.
TEST(Plan, UnknownSpaceIsCrossedOnlyWhenItPays) {
  PlanInputs inputs{FreeGrid(60, 60, 0.1), {}, {}};
  FillCells(28, 0, 32, 50, kUnknownCell, &inputs.grid);
  PlanOptions options = Between("1.5,1.5", "4.5,1.5");
  const auto length_m = [&](const std::string& unknown, double weight) {
    options.cost.unknown = unknown;
    options.cost.unknown_weight = weight;
    double in_unknown_m = 0;
    const PlanResult result = Plan(options, inputs);
    for (const PathPoint& point : result.path) {
      in_unknown_m += inputs.grid.At(inputs.grid.CellOf(point.point_in_map)) == kUnknownCell;
    }
    EXPECT_EQ(in_unknown_m > 0, TotalLength_m(result) < 3.1);
    return TotalLength_m(result);
  };
  for (const char* planner : {"any_angle", "astar"}) {
    options.planner = planner;
    EXPECT_GT(length_m("forbidden", 0), 7);
    EXPECT_NEAR(length_m("allowed", 0), 3, 1e-6);
    EXPECT_NEAR(length_m("costed", 5), 3, 0.1);
    EXPECT_NEAR(length_m("costed", 1), 3, 0.1);
  }
  options.cost.unknown_weight = 10;
  FillCells(18, 0, 42, 35, kUnknownCell, &inputs.grid);
  EXPECT_GT(length_m("costed", 10), 4.5);
}

TEST(PlanErrors, Unreachable) {
  PlanOptions options = Between("1.25,2.45", "2.65,2.55", 0);
  ExpectError(options, Rooms(), {"no path", "from the other, which reaches 0.0"});
  // With unknown space allowed there is a way round through the corner.
  options.cost.unknown = "allowed";
  options.footprint.robot_radius_m = 0;  // the way through is one cell wide
  EXPECT_GT(TotalLength_m(Plan(options, Rooms())), 1.4);
}

TEST(PlanErrors, UnusablePictures) {
  PlanInputs inputs = RoomsWithPictures();
  const auto expect = [&](const std::string& name, const std::vector<std::string>& parts) {
    ExpectError(Between("picture:" + name, "picture:b"), inputs, parts);
  };
  expect("or/a.png", {"not among"});  // not the name of its folder
  expect("..", {"not among"});
  expect("missing", {"'missing'", "site/color/a.png"});
  expect("a", {"fits 2", "other/a.jpg"});
  inputs.queries.pop_back();
  expect("lost", {"not located", "too_few_inliers"});
  inputs.queries[0].verdict = QueryVerdict::kAmbiguous;  // has a pose, but perhaps the wrong one
  expect("lost", {"ambiguous"});
  inputs.queries.clear();
  expect("a", {"not among the 0"});
}

TEST(PathOutput, CsvAndJsonAgree) {
  PlanInputs inputs = TwoFloorsWithPictures();
  inputs.floor_idx = 2;
  const PlanResult result = Plan(Between("1.25,2.2,2.9", "2.2,2.65,2.9"), inputs);
  std::istringstream csv(PathToCsv(result));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "x_m,y_m,heading_rad,distance_m,leg_idx,clearance_m,z_m,floor");
  std::size_t num_rows = 0;
  std::string last;
  while (std::getline(csv, line)) {
    ++num_rows;
    last = line;
  }
  const auto json = PathToJson(result, "a = 1\n");
  EXPECT_EQ(json.at("format"), "nightmap_path");
  EXPECT_EQ(json.at("version"), 3);
  EXPECT_EQ(json.at("floor"), 1);
  EXPECT_EQ(json.at("floor_height_m"), 2.9);
  EXPECT_EQ(json.at("start").at("z_m"), 2.9);
  EXPECT_EQ(json.at("num_points"), num_rows);
  std::vector<double> columns;
  std::istringstream row(last);
  for (std::string column; std::getline(row, column, ',');) columns.push_back(std::stod(column));
  ASSERT_EQ(columns.size(), 8U);
  EXPECT_EQ(columns[6], 2.9);
  EXPECT_EQ(columns[7], 1);
  EXPECT_NEAR(columns[3], json.at("length_m"), 1e-6);
  EXPECT_EQ(json.at("start").at("moved_by_m"), 0);
}

// Read as YAML by the e2e test; here the numbers.
TEST(PathOutput, NavPathHasAPoseForEachPoint) {
  PlanInputs inputs = TwoFloorsWithPictures();
  inputs.floor_idx = 0;
  const PlanResult result = Plan(Between("1.25,2.2,-3.2", "2.2,2.65,-3.2"), inputs);
  EXPECT_THAT(PathToNavYaml(result), testing::StartsWith("# floor -1 (z = -3.20 m)\nheader:"));
  std::istringstream yaml(PathToNavYaml(result));
  std::vector<std::array<double, 4>> poses;  // x y, z w of the quaternion
  for (std::string line; std::getline(yaml, line);) {
    double a = 0;
    double b = 0;
    double z = 0;
    if (std::sscanf(line.c_str(), "    position: {x: %lf, y: %lf, z: %lf}", &a, &b, &z) == 3) {
      EXPECT_EQ(z, -3.2);
      poses.push_back({a, b, 0, 0});
    }
    if (std::sscanf(line.c_str(), "    orientation: {x: 0.0, y: 0.0, z: %lf, w: %lf}", &a, &b) ==
        2) {
      poses.back()[2] = a;
      poses.back()[3] = b;
    }
  }
  ASSERT_EQ(poses.size(), result.path.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const PathPoint& point = result.path[i];
    EXPECT_NEAR(poses[i][0], point.point_in_map.x(), 1e-6);
    EXPECT_NEAR(poses[i][1], point.point_in_map.y(), 1e-6);
    EXPECT_NEAR(std::remainder(2 * std::atan2(poses[i][2], poses[i][3]) - point.heading_rad,
                               2 * std::numbers::pi),
                0,
                1e-6);
  }
}

TEST(PathOutput, PictureShowsBothEndsAndKeepsObstacles) {
  PlanInputs inputs = Rooms();
  inputs.trajectory.resize(2);
  inputs.trajectory[1].pose.translation = {1e9, -1e9, 0};  // off the picture: must not fail
  const PlanOptions options = Between("1.25,2.2", "2.2,2.65");
  const PlanResult result = Plan(options, inputs);
  const ColorImage image = DrawPath(options, inputs, result);
  const int scale = image.width / inputs.grid.width;
  EXPECT_EQ(image.width, inputs.grid.width * scale);
  EXPECT_EQ(image.height, inputs.grid.height * scale);
  const auto at = [&](const Eigen::Vector2d& point) {
    const Eigen::Vector2d pixel = inputs.grid.ToCells(point) * scale;
    const int x = static_cast<int>(pixel.x());
    const int y = image.height - 1 - static_cast<int>(pixel.y());
    return std::array<int, 3>{image.At(x, y, 0), image.At(x, y, 1), image.At(x, y, 2)};
  };
  EXPECT_GT(at({1.25, 2.2})[1], at({1.25, 2.2})[0]);  // green start
  EXPECT_GT(at({2.2, 2.65})[0], at({2.2, 2.65})[1]);  // red goal
  EXPECT_EQ(at({1.55, 2.15}), (std::array<int, 3>{40, 40, 40}));
}

TEST(PathOutput, PictureOfAFloorNamesItAndShowsItsTrajectoryOnly) {
  PlanInputs inputs = TwoFloorsWithPictures();
  inputs.floor_idx = 2;
  const PlanOptions options = Between("1.25,2.2,2.9", "1.25,2.65,2.9");
  const PlanResult result = Plan(options, inputs);
  const auto draw = [&] { return DrawPath(options, inputs, result).pixels; };
  const auto without = draw();
  inputs.trajectory.resize(2);
  inputs.trajectory[0].pose.translation = {1.7, 2.3, 1.2};
  inputs.trajectory[1].pose.translation = {2.3, 2.6, 1.2};
  EXPECT_EQ(draw(), without);
  for (StampedPose& pose : inputs.trajectory) pose.pose.translation.z() += 2.9;
  EXPECT_NE(draw(), without);
  inputs.trajectory.clear();
  inputs.floors = {inputs.floors[2]};
  inputs.floor_idx = 0;
  EXPECT_NE(draw(), without);  // the only floor needs no name
}

}  // namespace nightmap::plan_test
