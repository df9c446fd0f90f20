// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/tiles/tiles.h"

#include <gtest/gtest.h>

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/base/random.h"

namespace nightmap::tiles_test {

constexpr int kNumKeyframes = 60;

RgbdCamera WideCamera() {
  RgbdCamera camera;
  camera.color = {160, 120, 110, 110, 79.5, 59.5, 0.12, -0.05, 0.002, -0.001, 0};
  return camera;
}

// Level or tilted cameras anywhere in a building of 60 m x 40 m.
std::vector<Keyframe> Wander(int num_keyframes) {
  const Eigen::Quaterniond map_from_level(
      (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished());
  std::vector<Keyframe> keyframes;
  for (int i = 0; i < num_keyframes; ++i) {
    Random random(11, static_cast<std::uint64_t>(i));
    Keyframe keyframe;
    keyframe.keyframe_idx = i;
    keyframe.frame = {i, 1000 * i, 0, 0, {"c.jpg", "0"}, {"d.png", "1"}, {}};
    keyframe.map_from_camera = {
        Eigen::AngleAxisd(random.Uniform(-M_PI, M_PI), Eigen::Vector3d::UnitZ()) * map_from_level *
            Eigen::AngleAxisd(random.Uniform(-1, 1), Eigen::Vector3d::UnitX()),
        {random.Uniform(-30, 30), random.Uniform(-20, 20), random.Uniform(0.5, 2)}};
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

bool Lists(const Tile& tile, int keyframe_idx) {
  return std::ranges::count(tile.keyframes, keyframe_idx, &Keyframe::keyframe_idx) > 0;
}

TilesOptions SmallTiles() {
  TilesOptions options;
  options.edge_m = 8;
  return options;
}

class TilesOfAnyEdge : public testing::TestWithParam<double> {};

// Edges of the second and the third kind are shorter than a view.
INSTANTIATE_TEST_SUITE_P(Edges_m, TilesOfAnyEdge, testing::Values(8.0, 2.6, 1.0));

TEST_P(TilesOfAnyEdge, WhateverAKeyframeMeasuresIsInOneTileThatListsIt) {
  const RgbdCamera camera = WideCamera();
  const auto keyframes = Wander(GetParam() < 8 ? kNumKeyframes / 10 : kNumKeyframes);
  TilesOptions options;
  options.edge_m = GetParam();
  const auto tiles = RunTiles(options, {camera}, keyframes);
  for (const Keyframe& keyframe : keyframes) {
    Random random(12, static_cast<std::uint64_t>(keyframe.keyframe_idx));
    for (int i = 0; i < 300; ++i) {
      const Eigen::Vector2d pixel(static_cast<double>(random.Index(160)),
                                  static_cast<double>(random.Index(120)));
      const Eigen::Vector3d point =
          keyframe.map_from_camera *
          camera.color.BackProject(pixel, random.Uniform(0, options.max_range_m));
      int num_owners = 0;
      for (const auto& [index, tile] : tiles) {
        const Rectangle seen = tile.region.inside.Grown(options.overlap_m);
        num_owners += tile.region.inside.Contains(point.head<2>());
        if (seen.Contains(point.head<2>())) {
          EXPECT_TRUE(Lists(tile, keyframe.keyframe_idx)) << TileName(index);
        }
      }
      EXPECT_EQ(num_owners, 1);
    }
  }
}

TEST(Tiles, ListNoKeyframeThatIsOutOfReach) {
  const auto keyframes = Wander(kNumKeyframes);
  const TilesOptions options = SmallTiles();
  for (const auto& [index, tile] : RunTiles(options, {WideCamera()}, keyframes)) {
    for (const Keyframe& keyframe : tile.keyframes) {
      // Everything that a camera may see is nearer than the corner of its view, 1.35 times the
      // depth.
      const double reach_m = 1.35 * options.max_range_m + options.overlap_m;
      const Eigen::Vector2d centre = keyframe.map_from_camera.translation.head<2>();
      EXPECT_TRUE(tile.region.inside.Grown(reach_m).Contains(centre));
    }
  }
}

TEST(Tiles, AViewAwayFromABorderIsNotListedBeyondIt) {
  Keyframe keyframe = Wander(1).front();
  keyframe.map_from_camera.rotation =
      Eigen::Quaterniond((Eigen::Matrix3d() << 0, 0, -1, 1, 0, 0, 0, -1, 0).finished());
  keyframe.map_from_camera.translation = {3, 0, 1};  // a metre from the border, looking along -x
  const auto tiles = RunTiles(SmallTiles(), {WideCamera()}, {keyframe});
  EXPECT_TRUE(tiles.contains({0, 0}));
  EXPECT_FALSE(tiles.contains({1, 0}));
}

TEST(Tiles, ASmallBuildingAboutTheOriginIsOne) {
  auto keyframes = Wander(kNumKeyframes);
  for (Keyframe& keyframe : keyframes) keyframe.map_from_camera.translation *= 0.1;
  EXPECT_EQ(RunTiles({}, {WideCamera()}, keyframes).size(), 1U);
}

TEST(Tiles, AppendedFramesChangeOnlyTheTilesTheySee) {
  auto keyframes = Wander(kNumKeyframes);
  const auto before = RunTiles(SmallTiles(), {WideCamera()}, keyframes);
  for (int i = 0; i < kNumKeyframes / 10; ++i) {
    Keyframe keyframe = keyframes[static_cast<std::size_t>(i)];
    keyframe.keyframe_idx += kNumKeyframes;
    keyframe.map_from_camera.translation.x() += 100;
    keyframes.push_back(keyframe);
  }
  const auto after = RunTiles(SmallTiles(), {WideCamera()}, keyframes);
  EXPECT_GT(after.size(), before.size());
  for (const auto& [index, tile] : before) {
    EXPECT_EQ(TileToJson(after.at(index)), TileToJson(tile)) << TileName(index);
  }
}

TEST(Tiles, PosesFarOutAreRefused) {
  auto keyframes = Wander(3);
  keyframes[1].map_from_camera.translation.y() = 1e9;
  EXPECT_THROW(RunTiles({}, {WideCamera()}, keyframes), DataError);
}

TEST(Tiles, ACameraThatSeesTooFarToTheSideIsRefused) {
  const auto keyframes = Wander(1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double fx : {1e-300, 1e-3, 3.0, nan}) {
    RgbdCamera camera = WideCamera();
    camera.color = {160, 120, fx, 110, 79.5, 59.5, 0, 0, 0, 0, 0};
    EXPECT_THROW(RunTiles({}, {camera}, keyframes), InputError) << fx;
  }
  RgbdCamera wide = WideCamera();
  wide.color = {160, 120, 8, 8, 79.5, 59.5, 0, 0, 0, 0, 0};  // 84 degrees off the axis
  EXPECT_FALSE(RunTiles({}, {wide}, keyframes).empty());
}

}  // namespace nightmap::tiles_test
