// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/things.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "pipeline/base/input_error.h"
#include "pipeline/base/random.h"
#include "tests/stages/labels/things/seen_room.h"
#include "tests/test_data.h"

namespace nightmap::things_test {

constexpr double kVoxel_m = 0.05;
constexpr double kRadPerDeg = std::numbers::pi / 180;

std::vector<Thing> Find(const ThingsInputs& inputs, int num_threads = 1) {
  Progress progress("things", false);
  return RunThings(ThingsOptions{}, inputs, progress, num_threads);
}

Solid Floor() { return {kFloor, {}, -0.2, {12, 12, 0.2}}; }

// Turns about the map's origin, where a whole scene is turned.
Solid Turned(Solid solid, double heading_rad) {
  solid.map_from_solid = Rigid2{heading_rad, {0, 0}} * solid.map_from_solid;
  return solid;
}

// A wall whose face is at y = 2 and a cabinet 2 m high before it; cameras stand before both.
SeenRoom CabinetAtWall(double heading_rad, double gap_m = 0) {
  SeenRoom room;
  const Solid wall{kWall, {0, {0.013, 2.1}}, 0, {6, 0.2, 2.7}};
  const Solid cabinet{kCabinet, {0, {0.013, 1.7 - gap_m}}, 0, {1.1, 0.6, 2}};
  for (const Solid& solid : {cabinet, Floor(), wall}) {
    room.solids.push_back(Turned(solid, heading_rad));
  }
  const Rigid3 turn = Rigid2{heading_rad, {0, 0}}.ToRigid3();
  for (const double x : {-0.8, 0.1, 0.7}) {
    room.cameras.push_back(turn * LookAt({x, -1, 1.4}, {0, 2, 1.1}));
  }
  room.cameras.push_back(turn * LookAt({0.2, -1, 1.5}, {0, 2, 2.2}));
  return room;
}

class CabinetTest : public testing::TestWithParam<int> {};

TEST_P(CabinetTest, IsCompletedToTheWallAndNotBeyond) {
  const double heading_rad = GetParam() * kRadPerDeg;
  const SeenRoom room = CabinetAtWall(heading_rad);
  const auto things = Find(room.Inputs());
  ASSERT_EQ(things.size(), 1U);
  const Thing& thing = things[0];
  EXPECT_EQ(thing.name, "cabinet_1");
  EXPECT_GT(IntersectionOverUnion(thing, room.solids[0]), 0.8);
  EXPECT_NEAR(thing.size_m.x(), 0.6, 2 * kVoxel_m);
  EXPECT_NEAR(thing.size_m.y(), 1.1, 2 * kVoxel_m);
  EXPECT_NEAR(thing.bottom_m, 0, kVoxel_m);
  // The front looks to the cameras, against the scene's y axis.
  const double off_rad =
      WrapAngle_rad(thing.map_from_thing.heading_rad - heading_rad + std::numbers::pi / 2);
  EXPECT_LT(std::abs(off_rad), 3 * kRadPerDeg);
  const Eigen::Vector2d back = thing.map_from_thing * Eigen::Vector2d(-thing.size_m.x() / 2, 0);
  EXPECT_LE((Rigid2{-heading_rad, {0, 0}} * back).y(), 2 + 0.5 * kVoxel_m);
}

INSTANTIATE_TEST_SUITE_P(Headings, CabinetTest, testing::Values(0, 30, 45, 118));

// A box in the middle of a room.
SeenRoom FreeStanding() {
  SeenRoom room;
  room.solids = {{kSofa, {0.3, {0.2, 0.1}}, 0, {1.4, 0.8, 0.7}}, Floor()};
  for (int i = 0; i < 6; ++i) {
    const double angle = i * std::numbers::pi / 3;
    room.cameras.push_back(
        LookAt({2.2 * std::cos(angle), 2.2 * std::sin(angle), 1.4}, {0, 0, 0.3}));
  }
  return room;
}

TEST(RunThings, ASideBeforeFreeSpaceStays) {
  const SeenRoom room = FreeStanding();
  const auto things = Find(room.Inputs());
  ASSERT_EQ(things.size(), 1U);
  Eigen::Vector2d size_m = things[0].size_m.head<2>();
  if (size_m.x() < size_m.y()) std::swap(size_m.x(), size_m.y());
  EXPECT_NEAR(size_m.x(), 1.4, 1.5 * kVoxel_m);
  EXPECT_NEAR(size_m.y(), 0.8, 1.5 * kVoxel_m);
  EXPECT_NEAR(things[0].bottom_m, 0, kVoxel_m);
  EXPECT_NEAR(things[0].size_m.z(), 0.7, 1.5 * kVoxel_m);
  EXPECT_EQ(things[0].num_views, 6);
  EXPECT_GT(things[0].confidence, 0.9);
}

TEST(RunThings, WhatHangsStaysAboveTheFloor) {
  SeenRoom room = CabinetAtWall(0);
  room.solids[0].bottom_m = 0.5;
  room.solids[0].size_m.z() = 0.6;
  const auto things = Find(room.Inputs());
  ASSERT_EQ(things.size(), 1U);
  EXPECT_NEAR(things[0].bottom_m, 0.5, 1.5 * kVoxel_m);
}

TEST(RunThings, AThingStandsOnWhatIsBelow) {
  SeenRoom room = FreeStanding();
  room.solids[1].bottom_m += 2.85;  // an upper floor
  room.solids[0].bottom_m += 2.85;
  for (Rigid3& camera : room.cameras) camera.translation.z() += 2.85;
  const auto things = Find(room.Inputs());
  ASSERT_EQ(things.size(), 1U);
  EXPECT_NEAR(things[0].bottom_m, 2.85, kVoxel_m);
}

TEST(RunThings, AWallHidesAThing) {
  SeenRoom room = FreeStanding();
  const auto seen = Find(room.Inputs());
  room.solids.push_back({kWall, {0, {1.5, 0}}, 0, {0.1, 8, 2.7}});
  const auto hidden = Find(room.Inputs());  // from three of six sides, two of them beside it
  ASSERT_EQ(hidden.size(), 1U);
  int num_behind = 0;
  for (const Rigid3& camera : room.cameras) num_behind += camera.translation.x() > 1.5;
  ASSERT_EQ(num_behind, 1);
  EXPECT_EQ(hidden[0].num_views, seen[0].num_views - num_behind);
  ASSERT_TRUE(hidden[0].best_view.has_value());
  EXPECT_NE(hidden[0].best_view->color_path, "0.png");  // that behind the wall
}

TEST(RunThings, TheBestViewShowsTheThing) {
  SeenRoom room = FreeStanding();
  room.cameras.insert(room.cameras.begin(), LookAt({2.2, 0, 1.4}, {0, 1.6, 0.3}));
  const auto things = Find(room.Inputs());
  ASSERT_EQ(things.size(), 1U);
  const ThingView& view = things[0].best_view.value();
  EXPECT_NE(view.color_path, "0.png");  // cut by the picture's border
  EXPECT_EQ(view.color_path, std::to_string(view.time_ns - 1000) + ".png");
  const auto& [left, top, right, bottom] = view.rectangle_px;
  EXPECT_LE(0, left);
  EXPECT_LT(left, 79);
  EXPECT_GT(right, 80);
  EXPECT_LE(right, 160);
  EXPECT_LT(top, bottom);
  EXPECT_LE(bottom, 120);
}

TEST(RunThings, TheBestViewIsOfThePictureAsStored) {
  SeenRoom room = FreeStanding();
  auto inputs = room.Inputs();
  const auto seen = Find(inputs)[0].best_view.value().rectangle_px;
  for (RgbdCamera& camera : inputs.cameras) {
    camera.picture_width = 3 * camera.color.width;
    camera.picture_height = 2 * camera.color.height;
  }
  const auto stored = Find(inputs)[0].best_view.value().rectangle_px;
  EXPECT_EQ(stored, (std::array{3 * seen[0], 2 * seen[1], 3 * seen[2], 2 * seen[3]}));
}

TEST(RunThings, SameAtAnyNumberOfThreadsAndInAnyOrderOfTiles) {
  SeenRoom room = FreeStanding();
  for (int i = 0; i < 5; ++i) {
    room.solids.push_back({kCabinet, {0.2 * i, {-1.6 + 0.8 * i, 1.2}}, 0, {0.4, 0.3, 0.5}});
  }
  ThingsInputs inputs = room.Inputs();
  const std::string bytes = ThingsToJson(Find(inputs, 1));
  EXPECT_THAT(bytes, testing::HasSubstr("cabinet_2"));
  Tile all, some;
  all.keyframes = some.keyframes = inputs.keyframes;
  some.keyframes.erase(some.keyframes.begin() + 1, some.keyframes.begin() + 3);
  inputs.keyframes = UniteKeyframes({some, all});
  ASSERT_EQ(inputs.keyframes.size(), all.keyframes.size());
  EXPECT_EQ(ThingsToJson(Find(inputs, 4)), bytes);
  inputs.keyframes = UniteKeyframes({all, some, some});
  EXPECT_EQ(ThingsToJson(Find(inputs, 4)), bytes);
}

TEST(RunThings, NamesHaveNoBlanksAndAreUnique) {
  SeenRoom room = FreeStanding();
  room.solids.push_back({kCabinet, {0, {1.2, 1.2}}, 0, {0.4, 0.3, 0.5}});
  ThingsInputs inputs = room.Inputs();
  inputs.voxels.classes[kSofa] = "arm chair";
  inputs.voxels.classes[kCabinet] = "arm_chair";
  const auto things = Find(inputs);
  ASSERT_EQ(things.size(), 2U);
  EXPECT_EQ(things[0].name, "arm_chair_1");
  EXPECT_EQ(things[0].class_name, "arm chair");
  EXPECT_EQ(things[1].name, "arm_chair_2");
  EXPECT_EQ(DescribeThings(things)["num_things_of_class"]["arm chair"], 1);
}

TEST(RunThings, ListsOnlyTheClassesAskedFor) {
  SeenRoom room = FreeStanding();
  room.solids.push_back({kCabinet, {0, {1.2, 1.2}}, 0, {0.4, 0.3, 0.5}});
  const ThingsInputs inputs = room.Inputs();
  Progress progress("things", false);
  ThingsOptions options;
  options.classes = {"cabinet"};
  const auto things = RunThings(options, inputs, progress, 1);
  ASSERT_EQ(things.size(), 1U);
  EXPECT_EQ(things[0].name, "cabinet_1");
  options.classes = {"cabinets"};
  NIGHTMAP_EXPECT_ERROR(UsageError, RunThings(options, inputs, progress, 1), "cabinet");
  options.classes = {};
  options.leave_out.push_back("cabinet");
  EXPECT_EQ(RunThings(options, inputs, progress, 1)[0].class_name, "sofa");
}

TEST(RunThings, OtherResolutionsAreRefused) {
  ThingsInputs inputs = FreeStanding().Inputs();
  inputs.voxels.resolution_m = 0.1;
  NIGHTMAP_EXPECT_ERROR(InputError, Find(inputs), "voxels of 0.05 m and of 0.1 m");
}

TEST(RunThings, NothingLabelledIsNothing) {
  ThingsInputs inputs = FreeStanding().Inputs();
  const VoxelLabels labelled = inputs.voxels;
  inputs.voxels = {labelled.resolution_m, labelled.classes, {}, {}, {0}, {}, {}};
  EXPECT_TRUE(Find(inputs).empty());
  EXPECT_EQ(DescribeThings({})["num_things"], 0);
}

class PartlySeenTest : public testing::TestWithParam<int> {};

TEST_P(PartlySeenTest, TheBoxIsLikeTheThing) {
  Random random(7, static_cast<std::uint64_t>(GetParam()));
  const double heading_rad = random.Uniform(0, 6.28);
  const Eigen::Vector3d size_m(
      random.Uniform(0.5, 1.8), random.Uniform(0.35, 0.8), random.Uniform(0.4, 2));
  const bool at_wall = GetParam() % 2 == 0;
  const double y_m = 2 - size_m.y() / 2 - random.Uniform(0, 0.08);
  SeenRoom room;
  room.solids.push_back(Turned({kSofa, {0, {0.02, y_m}}, 0, size_m}, heading_rad));
  room.solids.push_back(Floor());
  if (at_wall) room.solids.push_back(Turned({kWall, {0, {0, 2.1}}, 0, {7, 0.2, 2.7}}, heading_rad));
  const Rigid3 turn = Rigid2{heading_rad, {0, 0}}.ToRigid3();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d from(random.Uniform(-1.8, 1.8), random.Uniform(-1, -0.2), 1.45);
    room.cameras.push_back(turn * LookAt(from, {0, y_m, size_m.z() / 2}));
  }
  const auto things = Find(room.Inputs(), 2);
  ASSERT_EQ(things.size(), 1U);
  EXPECT_GT(IntersectionOverUnion(things[0], room.solids[0]), 0.5)
      << size_m.transpose() << " found as " << things[0].size_m.transpose();
  RecordProperty("iou", std::to_string(IntersectionOverUnion(things[0], room.solids[0])));
}

INSTANTIATE_TEST_SUITE_P(Random, PartlySeenTest, testing::Range(0, 16));

}  // namespace nightmap::things_test
