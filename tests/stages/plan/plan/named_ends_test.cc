// SPDX-License-Identifier: Apache-2.0
// Ends of a path that are located scans or objects of the map.

#include "stages/plan/plan/plan.h"
#include "tests/stages/plan/plan/planning.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap::named_ends_test {

MapObject Object(const std::string& name,
                 const Eigen::Vector2d& centre,
                 const Eigen::Vector2d& size_m) {
  return {name, {0, centre}, size_m, {}};
}

// Cells of 0.1 m from (1, 2) to (3, 3): a hall with a column of 0.4 m in its middle, at (2, 2.5).
PlanInputs Hall() {
  PlanInputs inputs;
  inputs.grid = GridFromText({"####################",
                              "#..................#",
                              "#..................#",
                              "#.......####.......#",
                              "#.......####.......#",
                              "#.......####.......#",
                              "#.......####.......#",
                              "#..................#",
                              "#..................#",
                              "####################"});
  inputs.queries = {Located("../logs/wake.log#1", 1.25, 2.25),
                    Located("../logs/wake.log#2", 2.75, 2.75),
                    Lost("logs/lost.log", "low_score")};
  inputs.objects = {Object("column", {2, 2.5}, {0.4, 0.4}),
                    Object("left wall", {1, 2.5}, {0.2, 0.8})};
  return inputs;
}

PlanOptions Between(const std::string& start, const std::string& goal) {
  return nightmap::Between(start, goal, 0, 0.1);
}

TEST(NamedEnds, ScansAreFoundByPathOrItsEnd) {
  for (const char* name : {"../logs/wake.log#1", "logs/wake.log#1", "wake.log#1"}) {
    const PlanResult result = Plan(Between(std::string("scan:") + name, "scan:wake.log#2"), Hall());
    EXPECT_EQ(result.ends[0].point_in_map, Eigen::Vector2d(1.25, 2.25)) << name;
    EXPECT_EQ(result.ends[1].point_in_map, Eigen::Vector2d(2.75, 2.75)) << name;
    EXPECT_FALSE(result.ends[0].request.is_picture);
  }
}

void ExpectRefused(const std::string& goal, const PlanInputs& inputs, const std::string& text) {
  ExpectError(Between("1.25,2.25", goal), inputs, {text});
}

TEST(NamedEnds, AScanThatIsUnknownOrWasNotLocatedIsNoEnd) {
  ExpectRefused("scan:sleep.log",
                Hall(),
                "scan 'sleep.log' is not among the 3 localized queries "
                "(../logs/wake.log#1, ../logs/wake.log#2, logs/lost.log)");
  ExpectRefused("scan:lost.log", Hall(), "scan 'lost.log' was not located: not_in_map (low_score)");
  PlanInputs twice = Hall();
  twice.queries[1].color_path = "other/wake.log#1";
  ExpectRefused("scan:wake.log#1", twice, "scan 'wake.log#1' fits 2 queries");
}

// The nearest free cells are farther from the column's centre than snap_radius_m.
TEST(NamedEnds, APathToAnObjectEndsBesideIt) {
  const PlanResult result = Plan(Between("scan:wake.log#1", "object:column"), Hall());
  const Endpoint& goal = result.ends[1];
  EXPECT_EQ(goal.request.point_in_map, Eigen::Vector2d(2, 2.5));
  EXPECT_TRUE(Hall().grid.At(goal.cell) == kFreeCell);
  EXPECT_GT(goal.moved_by_m, 0.2);
  EXPECT_LE(goal.moved_by_m, 0.2 * std::sqrt(2.0) + 0.1);
  EXPECT_EQ(result.path.back().point_in_map, goal.point_in_map);
  const PlanResult there = Plan(Between("object:left wall", "object:column"), Hall());
  EXPECT_EQ(there.ends.size(), 2U);
  EXPECT_LT(there.ends[0].point_in_map.x(), 1.3);
}

TEST(NamedEnds, AnObjectWithoutPlaceAroundItIsRefused) {
  PlanOptions options = Between("1.45,2.45", "object:column");
  options.footprint.robot_radius_m = 0.12;
  options.snap_radius_m = 0;
  ExpectError(
      options, Hall(), {"0.25 m from its rectangle at \"1.550,2.350\", more than snap_radius_m 0"});
  options.snap_radius_m = 0.3;
  EXPECT_GT(Plan(options, Hall()).ends[1].moved_by_m, 0.28);
}

TEST(NamedEnds, AnObjectMayLieInTheRimOfTheMap) {
  PlanInputs inputs = Hall();
  inputs.objects = {Object("door", {0.95, 2.5}, {0.2, 0.9})};  // its centre is 5 cm outside
  const PlanResult result = Plan(Between("2.75,2.75", "object:door"), inputs);
  EXPECT_LT(result.ends[1].point_in_map.x(), 1.3);
  inputs.objects[0].map_from_object.translation = {-50, 2.5};
  ExpectRefused("object:door", inputs, "'object:door' at -50.000,2.500 is outside of the map");
}

TEST(NamedEnds, AnObjectThatIsFreeIsItsCentre) {
  PlanInputs inputs = Hall();
  inputs.objects = {Object("rug", {2.75, 2.75}, {0.2, 0.2})};
  EXPECT_EQ(Plan(Between("1.25,2.25", "object:rug"), inputs).ends[1].moved_by_m, 0);
}

TEST(NamedEnds, UnknownObjectsNameTheKnownOnes) {
  ExpectRefused(
      "object:pillar", Hall(), "object 'pillar' is not among the 2 of the map (column, left wall)");
  PlanInputs none = Hall();
  none.objects.clear();
  ExpectRefused(
      "object:column", none, "object 'column': the map has no objects: name a file of them");
  for (const char* text : {"scan:", "object:", "Object:column"}) {
    ExpectError<UsageError>(Between(text, "1.25,2.25"), Hall(), {"\"object:NAME\""});
  }
}

}  // namespace nightmap::named_ends_test
