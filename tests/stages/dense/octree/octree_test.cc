// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/octree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/geometry/voxel_key.h"
#include "tests/stages/dense/point_cloud/box_room.h"
#include "tests/test_data.h"

namespace nightmap::octree_test {

OctreeOptions TestOptions() {
  OctreeOptions options;
  options.resolution_m = 0.1;
  options.depth_filter.pixel_stride = 1;
  return options;
}

OctreeResult MakeTree(const OctreeOptions& options,
                      const KeyframeSource& source,
                      const std::vector<CloudPoint>* cloud = nullptr,
                      int num_threads = 2) {
  Progress progress("octree", false);
  return RunOctree(options, source, cloud, std::nullopt, progress, num_threads);
}

enum class State { kUnknown, kFree, kOccupied };

State StateAt(const OccupancyTree& tree, const Eigen::Vector3d& point) {
  for (const auto& leaf : tree.leaves) {
    if ((point - leaf.centre_in_map).cwiseAbs().maxCoeff() <= leaf.size_m / 2) {
      return leaf.Occupied() ? State::kOccupied : State::kFree;
    }
  }
  return State::kUnknown;
}

// Points a hand's width apart on the wall x = x_m.
std::vector<CloudPoint> WallCloud(double x_m) {
  std::vector<CloudPoint> cloud;
  for (double y = -2.5; y < 2.5; y += 0.05) {
    for (double z = -1.2; z < 1.2; z += 0.05) {
      CloudPoint point;
      point.position_in_map = Eigen::Vector3d(x_m, y, z).cast<float>();
      cloud.push_back(point);
    }
  }
  return cloud;
}

std::string OctreeBytes(const OctreeResult& result) {
  const auto path =
      std::filesystem::temp_directory_path() / fmt::format("nightmap_stage_{}.ot", getpid());
  WriteOctree(path, result.tree);
  const std::string bytes = ReadFile(path);
  std::filesystem::remove(path);
  return bytes;
}

TEST(Octree, WallIsOccupiedFrontIsFreeBehindIsUnknown) {
  const BoxRoom room;
  const auto result = MakeTree(TestOptions(), LookAround(room, 12));
  for (const double y : {-0.55, 0.05, 0.65}) {
    EXPECT_EQ(StateAt(result.tree, {room.max_m.x(), y, 0.05}), State::kOccupied);
    EXPECT_EQ(StateAt(result.tree, {room.max_m.x() - 0.5, y, 0.05}), State::kFree);
    EXPECT_EQ(StateAt(result.tree, {room.max_m.x() + 0.5, y, 0.05}), State::kUnknown);
  }
  EXPECT_GT(result.num_free, result.num_occupied);
}

TEST(Octree, OccupiedVoxelsAreNearWallsAndColored) {
  const BoxRoom room;
  const auto result = MakeTree(TestOptions(), LookAround(room, 12));
  for (const auto& leaf : result.tree.leaves) {
    if (!leaf.Occupied()) continue;
    EXPECT_LT(room.DistanceToWall_m(leaf.centre_in_map), 0.25);
    EXPECT_EQ(leaf.rgb, (std::array<std::uint8_t, 3>{90, 90, 90}));
  }
}

TEST(Octree, LogOddsStayWithinTheClamps) {
  const auto result = MakeTree(TestOptions(), LookAround(BoxRoom(), 24));
  for (const auto& leaf : result.tree.leaves) {
    EXPECT_GE(leaf.log_odds, std::log(0.12 / 0.88) - 1e-5);
    EXPECT_LE(leaf.log_odds, std::log(0.97 / 0.03) + 1e-5);
  }
}

// A miss alone stays above a threshold below it, and yet occupies nothing.
TEST(Octree, WhatWasNeverHitIsNotOccupied) {
  OctreeOptions options = TestOptions();
  options.occupancy_threshold = 0.13;
  const BoxRoom room;
  for (const std::string builder : {"batched", "octomap"}) {
    options.builder = builder;
    const auto result = MakeTree(options, LookAround(room, 12));
    EXPECT_GT(result.num_occupied, 0U);
    for (const auto& leaf : result.tree.leaves) {
      EXPECT_TRUE(!leaf.Occupied() || room.DistanceToWall_m(leaf.centre_in_map) < 0.25);
    }
  }
}

TEST(Octree, AThresholdThatNoVoxelCanBeOnBothSidesOfIsRefused) {
  for (const double threshold : {0.05, 0.12, 0.9701}) {
    OctreeOptions options = TestOptions();
    options.occupancy_threshold = threshold;
    NIGHTMAP_EXPECT_ERROR(
        UsageError, MakeTree(options, LookAround(BoxRoom(), 1)), "occupancy_threshold");
  }
}

TEST(Octree, RaysBeyondTheRangeOnlyFree) {
  OctreeOptions options = TestOptions();
  options.max_range_m = 2.3;  // walls across x are nearer, those across y are not
  const BoxRoom room;
  const auto result = MakeTree(options, LookAround(room, 12));
  EXPECT_EQ(StateAt(result.tree, {room.max_m.x(), 0.05, 0.05}), State::kOccupied);
  EXPECT_EQ(StateAt(result.tree, {0.05, 2.05, 0.05}), State::kFree);
  EXPECT_EQ(StateAt(result.tree, {0.05, room.max_m.y(), 0.05}), State::kUnknown);
}

TEST(Octree, OnlyWhatTheCloudSupportsBecomesOccupied) {
  const BoxRoom room;
  const auto cloud = WallCloud(room.max_m.x());
  const auto source = LookAround(room, 12);
  const auto result = MakeTree(TestOptions(), source, &cloud);
  EXPECT_EQ(StateAt(result.tree, {room.max_m.x(), 0.05, 0.05}), State::kOccupied);
  EXPECT_NE(StateAt(result.tree, {room.min_m.x(), 0.05, 0.05}), State::kOccupied);
  EXPECT_GT(result.num_unsupported, 0U);
  OctreeOptions without = TestOptions();
  without.require_cloud_support = false;
  EXPECT_EQ(OctreeBytes(MakeTree(without, source, &cloud)),
            OctreeBytes(MakeTree(TestOptions(), source)));
}

TEST(Octree, HolesInTheDepthLeaveSpaceUnknown) {
  const BoxRoom room;
  auto source = LookAround(room, 1);  // looks along +x
  const auto load = source.load;
  source.load = [load](const Keyframe& keyframe) {
    RgbdImages images = load(keyframe);
    for (int y = 0; y < 120; ++y) {
      for (int x = 80; x < 160; ++x) images.depth.At(x, y) = 0;  // y < 0 in the map
    }
    return images;
  };
  const auto result = MakeTree(TestOptions(), source);
  EXPECT_EQ(StateAt(result.tree, {1.05, 0.35, 0.05}), State::kFree);
  EXPECT_EQ(StateAt(result.tree, {1.05, -0.35, 0.05}), State::kUnknown);
}

TEST(Octree, DiscretizingCastsFewerRaysToTheSameWalls) {
  const BoxRoom room;
  OctreeOptions options = TestOptions();
  const auto merged = MakeTree(options, LookAround(room, 12));
  options.discretize = false;
  const auto all = MakeTree(options, LookAround(room, 12));
  EXPECT_LT(5 * merged.num_rays, all.num_rays);
  EXPECT_NEAR(static_cast<double>(merged.num_occupied),
              static_cast<double>(all.num_occupied),
              0.15 * static_cast<double>(all.num_occupied));
}

TEST(Octree, IsTheSameAtAnyNumberOfThreads) {
  const auto source = LookAround(BoxRoom(), 12);
  const std::string one = OctreeBytes(MakeTree(TestOptions(), source, nullptr, 1));
  EXPECT_EQ(OctreeBytes(MakeTree(TestOptions(), source, nullptr, 2)), one);
  EXPECT_EQ(OctreeBytes(MakeTree(TestOptions(), source, nullptr, 5)), one);
}

TEST(Octree, LeavesDoNotOverlapAndSitOnOctoMapsGrid) {
  const auto result = MakeTree(TestOptions(), LookAround(BoxRoom(), 12));
  std::set<std::uint64_t> seen;
  for (const auto& leaf : result.tree.leaves) {
    const Eigen::Vector3d corner = leaf.centre_in_map.array() - leaf.size_m / 2;
    const Eigen::Vector3d cells = corner / leaf.size_m;
    EXPECT_NEAR((cells - cells.array().round().matrix()).norm(), 0, 1e-6);
    EXPECT_TRUE(seen.insert(PackVoxel(VoxelOf(leaf.centre_in_map, 0.1))).second);
  }
}

TEST(Octree, SkipsUnreadableFramesWithTheReason) {
  BoxRoom room;
  room.unreadable = {1};
  EXPECT_THAT(MakeTree(TestOptions(), LookAround(room, 4)).skipped,
              testing::ElementsAre("frame 1: truncated"));
}

TEST(Octree, WithoutDepthIsAnErrorWithARemedy) {
  BoxRoom room;
  room.with_depth = false;
  try {
    MakeTree(TestOptions(), LookAround(room, 3));
    FAIL() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("depth_units_per_m"));
  }
}

TEST(Octree, PosesBeyondTheTreesReachAreAnError) {
  auto source = LookAround(BoxRoom(), 3);
  source.keyframes[1].map_from_camera.translation.x() = 4000;
  EXPECT_THROW(MakeTree(TestOptions(), source), DataError);
}

}  // namespace nightmap::octree_test
