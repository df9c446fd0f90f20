// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "pipeline/base/error.h"
#include "stages/plan/path_output.h"
#include "stages/plan/search.h"
#include "tests/stages/plan/scene.h"

namespace nightmap {
namespace {

using testing::AllOf;
using testing::HasSubstr;

PlanResult Plan(const PlanOptions& options, const PlanInputs& inputs, int num_threads = 1) {
  Progress progress("plan", false);
  return RunPlan(options, inputs, progress, num_threads);
}

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

QueryResult Located(const std::string& color_path, double x, double y) {
  QueryResult query;
  query.verdict = QueryVerdict::kLocated;
  query.color_path = color_path;
  query.map_from_camera.translation = {x, y, 1.2};
  return query;
}

PlanInputs RoomsWithPictures() {
  PlanInputs inputs = Rooms();
  QueryResult lost = Located("site/color/lost.png", 0, 0);
  lost.verdict = QueryVerdict::kNotInMap;
  lost.reason = "too_few_inliers";
  inputs.queries = {lost,
                    Located("site/color/a.png", 1.25, 2.45),
                    Located("site/color/b.jpg", 2.15, 2.45),
                    Located("other/a.jpg", 1.35, 2.25),
                    Located("site/in_wall.png", 1.55, 2.15),
                    Located("site/closed.png", 2.65, 2.55),
                    lost};
  return inputs;
}

PlanOptions Between(const std::string& start, const std::string& goal) {
  PlanOptions options;
  options.start = start;
  options.goal = goal;
  options.robot.robot_radius_m = 0.1;
  return options;
}

template <typename ErrorType>
std::string ErrorOf(const PlanOptions& options, const PlanInputs& inputs) {
  try {
    Plan(options, inputs);
  } catch (const ErrorType& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

TEST(Plan, GoesThroughTheDoor) {
  const PlanResult result = Plan(Between("1.25,2.2", "2.2,2.7"), Rooms());
  EXPECT_EQ(result.path.front().point_in_map, Eigen::Vector2d(1.25, 2.2));
  EXPECT_LT((result.path.back().point_in_map - Eigen::Vector2d(2.2, 2.7)).norm(), 1e-12);
  EXPECT_GE(result.length_m, std::hypot(0.95, 0.5));
  EXPECT_LT(result.length_m, 1.4);
  EXPECT_GE(result.min_clearance_m, 0.1 - 1e-9);
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
    options.robot.robot_radius_m = random.Uniform(0, 0.12);
    options.robot.clearance_m = 0.3;
    options.shorten = seed % 4 != 0;
    const CostMap map = MakeCostMap(inputs.grid, options.robot, 1);
    const auto text = [&] {
      const Eigen::Vector2d point = inputs.grid.CenterInMap(RandomFreeCell(random, map));
      return fmt::format("{},{}", point.x(), point.y());
    };
    options.start = text();
    options.goal = text();
    try {
      const PlanResult result = Plan(options, inputs);
      ++num_found;
      for (const PathPoint& point : result.path) {
        const Eigen::Vector2i cell = inputs.grid.CellOf(point.point_in_map);
        EXPECT_GE(map.Clearance_m(cell), options.robot.robot_radius_m - 1e-9);
        EXPECT_GE(map.Clearance_m(cell), result.min_clearance_m - 1e-9);
      }
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), HasSubstr("no path"));
    }
  }
  EXPECT_GT(num_found, 100);
}

TEST(Plan, WeightKeepsAwayFromWalls) {
  PlanInputs inputs{OccupancyGrid{60, 60, 0.05, Eigen::Vector2d::Zero(), {}}, {}, {}};
  inputs.grid.cells.assign(3600, kFreeCell);
  for (int x = 20; x < 40; ++x) {  // a block in the middle, passed on its upper side
    for (int y = 0; y < 30; ++y) inputs.grid.cells[inputs.grid.Index(x, y)] = kOccupiedCell;
  }
  PlanOptions options;
  options.start = "0.4,1.2";
  options.goal = "2.6,1.2";
  options.robot.clearance_weight = 0;
  const PlanResult shortest = Plan(options, inputs);
  options.robot.clearance_weight = 10;
  const PlanResult safer = Plan(options, inputs);
  EXPECT_LT(shortest.length_m, safer.length_m);
  EXPECT_LT(shortest.min_clearance_m + 0.1, safer.min_clearance_m);
}

TEST(Plan, SameAtAnyNumberOfThreads) {
  Random random(4);
  PlanInputs inputs{Building(random, 300, 60), {}, {}};
  PlanOptions options = Between("1.1,1.1", "13,13");
  inputs.queries = {Located("start", 1.1, 1.1), Located("goal", 13, 13)};
  options.start = "picture:start";
  options.goal = "picture:goal";
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
    EXPECT_EQ(result.start.point_in_map, Eigen::Vector2d(1.25, 2.45)) << name;
    EXPECT_EQ(result.goal.point_in_map, Eigen::Vector2d(2.15, 2.45)) << name;
    EXPECT_EQ(result.start.moved_by_m, 0);
  }
}

TEST(Plan, EmptyEndsAreFirstAndLastLocated) {
  PlanInputs inputs = RoomsWithPictures();
  inputs.queries.erase(inputs.queries.begin() + 4, inputs.queries.end() - 1);
  const PlanResult result = Plan(Between("", ""), inputs);
  EXPECT_EQ(result.start.request.text, "picture:site/color/a.png");
  EXPECT_EQ(result.goal.request.text, "picture:other/a.jpg");
}

TEST(Plan, EmptyEndsFallBackToTheTrajectory) {
  PlanInputs inputs = Rooms();
  EXPECT_THAT(ErrorOf<UsageError>(Between("", ""), inputs), HasSubstr("option start is empty"));
  inputs.trajectory.resize(2);
  inputs.trajectory[0].pose.translation = {1.25, 2.45, 1};
  inputs.trajectory[1].pose.translation = {2.15, 2.45, 1};
  const PlanResult result = Plan(Between("", ""), inputs);
  EXPECT_EQ(result.goal.point_in_map, Eigen::Vector2d(2.15, 2.45));
  EXPECT_THAT(result.start.request.text, HasSubstr("trajectory"));
}

TEST(Plan, PictureInAnObstacleMovesAndSaysSo) {
  const PlanInputs inputs = RoomsWithPictures();
  const PlanResult result = Plan(Between("picture:in_wall", "picture:b"), inputs);
  EXPECT_GT(result.start.moved_by_m, 0.05);
  EXPECT_LE(result.start.moved_by_m, 0.5);
  EXPECT_NEAR((result.start.point_in_map - Eigen::Vector2d(1.55, 2.15)).norm(),
              result.start.moved_by_m,
              1e-12);
  PlanOptions options = Between("picture:in_wall", "picture:b");
  options.snap_radius_m = 0.05;
  EXPECT_THAT(
      ErrorOf<DataError>(options, inputs),
      AllOf(HasSubstr("start"), HasSubstr("nearest free cell"), HasSubstr("snap_radius_m")));
}

// The picture was taken in a closed cell; the nearest place that the goal can reach is used.
TEST(Plan, PictureInAClosedPocketMovesOutOfIt) {
  const PlanInputs inputs = RoomsWithPictures();
  const PlanResult result = Plan(Between("picture:closed", "picture:b"), inputs);
  EXPECT_GT(result.start.moved_by_m, 0.2);
  EXPECT_LT(result.start.point_in_map.x(), 2.4);
  PlanOptions options = Between("picture:closed", "picture:b");
  options.snap_radius_m = 0.2;
  EXPECT_THAT(ErrorOf<DataError>(options, inputs), HasSubstr("no path"));
}

TEST(PlanErrors, MalformedEnds) {
  for (const char* text : {"1.2",
                           "1.2,",
                           ",2",
                           "a,b",
                           "1,2,3",
                           "nan,2",
                           "1,inf",
                           "picture:",
                           "photo:a",
                           "1.2;2.2",
                           "1e999,0"}) {
    EXPECT_THAT(ErrorOf<UsageError>(Between(text, "1.25,2.45"), Rooms()), HasSubstr("option start"))
        << text;
    EXPECT_THAT(ErrorOf<UsageError>(Between("1.25,2.45", text), Rooms()), HasSubstr("option goal"))
        << text;
  }
}

TEST(PlanErrors, UnusableEnds) {
  const auto error = [](const std::string& goal) {
    return ErrorOf<DataError>(Between("1.25,2.45", goal), Rooms());
  };
  EXPECT_THAT(error("9,9"),
              AllOf(HasSubstr("goal '9,9'"),
                    HasSubstr("outside of the map"),
                    HasSubstr("nearest free cell")));
  EXPECT_THAT(error("1e200,-1e200"), HasSubstr("outside of the map"));
  EXPECT_THAT(error("1.55,2.25"), HasSubstr("inside an obstacle"));
  EXPECT_THAT(error("2.75,2.15"), HasSubstr("unknown space"));
  PlanOptions wide = Between("1.25,2.45", "1.45,2.25");
  wide.robot.robot_radius_m = 0.15;
  EXPECT_THAT(ErrorOf<DataError>(wide, Rooms()),
              AllOf(HasSubstr("robot_radius_m"), HasSubstr("nearest free cell is 0.1")));
  wide.robot.robot_radius_m = 4;
  EXPECT_THAT(ErrorOf<DataError>(wide, Rooms()), HasSubstr("no cell that is free"));
}

TEST(PlanErrors, Unreachable) {
  EXPECT_THAT(ErrorOf<DataError>(Between("1.25,2.45", "2.65,2.55"), Rooms()),
              AllOf(HasSubstr("no path"), HasSubstr("m2"), HasSubstr("from the goal")));
  // With unknown space allowed there is a way round through the corner.
  PlanOptions options = Between("1.25,2.45", "2.65,2.55");
  options.robot.unknown_is_obstacle = false;
  EXPECT_GT(Plan(options, Rooms()).length_m, 1.4);
}

TEST(PlanErrors, UnusablePictures) {
  const PlanInputs inputs = RoomsWithPictures();
  const auto error = [&](const std::string& name) {
    return ErrorOf<DataError>(Between("picture:" + name, "picture:b"), inputs);
  };
  EXPECT_THAT(error("or/a.png"), HasSubstr("not among"));  // not the name of its folder
  EXPECT_THAT(error(".."), HasSubstr("not among"));
  EXPECT_THAT(error("missing"), AllOf(HasSubstr("'missing'"), HasSubstr("site/color/a.png")));
  EXPECT_THAT(error("a"), AllOf(HasSubstr("fits 2"), HasSubstr("other/a.jpg")));
  PlanInputs once = inputs;
  once.queries.pop_back();
  EXPECT_THAT(ErrorOf<DataError>(Between("picture:lost", "picture:b"), once),
              AllOf(HasSubstr("not located"), HasSubstr("too_few_inliers")));
  once.queries[0].verdict = QueryVerdict::kAmbiguous;  // has a pose, but perhaps the wrong one
  EXPECT_THAT(ErrorOf<DataError>(Between("picture:lost", "picture:b"), once),
              HasSubstr("ambiguous"));
  EXPECT_THAT(ErrorOf<DataError>(Between("picture:a", "picture:b"), Rooms()),
              HasSubstr("not among the 0"));
}

TEST(PathOutput, CsvAndJsonAgree) {
  const PlanResult result = Plan(Between("1.25,2.2", "2.2,2.7"), Rooms());
  std::istringstream csv(PathToCsv(result));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "x_m,y_m,heading_rad,distance_m");
  std::size_t num_rows = 0;
  std::string last;
  while (std::getline(csv, line)) {
    ++num_rows;
    last = line;
  }
  const auto json = PathToJson(result, "a = 1\n");
  EXPECT_EQ(json.at("format"), "nightmap_path");
  EXPECT_EQ(json.at("version"), 1);
  EXPECT_EQ(json.at("num_points"), num_rows);
  EXPECT_NEAR(std::stod(last.substr(last.rfind(',') + 1)), json.at("length_m"), 1e-6);
  EXPECT_EQ(json.at("start").at("moved_by_m"), 0);
}

TEST(PathOutput, PictureShowsBothEndsAndKeepsObstacles) {
  PlanInputs inputs = Rooms();
  inputs.trajectory.resize(2);
  inputs.trajectory[1].pose.translation = {1e9, -1e9, 0};  // off the picture: must not fail
  const PlanOptions options = Between("1.25,2.2", "2.2,2.7");
  const PlanResult result = Plan(options, inputs);
  const ColorImage image = DrawPath(inputs, result, options.robot.robot_radius_m);
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
  EXPECT_GT(at({2.2, 2.7})[0], at({2.2, 2.7})[1]);    // red goal
  EXPECT_EQ(at({1.55, 2.15}), (std::array<int, 3>{40, 40, 40}));
}

TEST(PlanOptions, SurviveToml) {
  PlanOptions options;
  OptionList list = RegisterOptions(options);
  const std::string toml = list.ToToml();
  list.ParseToml(toml, "defaults");
  EXPECT_EQ(list.ToToml(), toml);
}

}  // namespace
}  // namespace nightmap
