// SPDX-License-Identifier: Apache-2.0
// The published check of motion, on boards at several depths before a wall.
#include "stages/labels/moving/epipolar_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <opencv2/core.hpp>

#include "pipeline/base/parallel.h"
#include "tests/stages/labels/moving/board_scene.h"

namespace nightmap::epipolar_check_test {

// Moving points, as shares of the corners on the mover and of all others.
struct Shares {
  double mover = 0;
  double others = 0;
};

class EpipolarCheckTest : public testing::Test {
 protected:
  std::vector<Eigen::Vector2f> Find(const Picture& before,
                                    const Picture& now,
                                    std::uint64_t seed = 1) {
    return MovingPoints(options_, kWindow_px, camera_, before.frame, now.frame, seed)
        .value_or(std::vector<Eigen::Vector2f>());
  }

  Shares Find(const View& view) {
    const Picture before = See(camera_, {});
    const Picture now = See(camera_, view);
    Shares found, all;
    for (const auto& at : Find(before, now)) ++(now.ShowsMover(at) ? found.mover : found.others);
    for (const auto& corner : before.frame.corners) {
      ++(before.ShowsMover(corner) ? all.mover : all.others);
    }
    EXPECT_GT(all.mover, 50);
    EXPECT_GT(all.others, 500);
    return {found.mover / all.mover, found.others / all.others};
  }

  EpipolarOptions options_;
  SmallCamera camera_ = MakeCamera();
};

const Eigen::Vector3d kRight_m(0.06, 0, 0);
const Eigen::Vector3d kForward_m(0, 0, 0.08);

TEST_F(EpipolarCheckTest, NothingMovesWhereOnlyTheCameraDoes) {
  for (const View& view : {View{kRight_m},
                           View{kForward_m},
                           View{kRight_m, 0.02},
                           View{{0.04, 0.02, 0.05}, 0.02},
                           View{{0, 0, 0}, 0.03},
                           View{}}) {
    const Shares shares = Find(view);
    EXPECT_LT(shares.mover, 0.15) << view.at_m.transpose() << ", " << view.yaw_rad;
    EXPECT_LT(shares.others, 0.02) << view.at_m.transpose() << ", " << view.yaw_rad;
  }
}

TEST_F(EpipolarCheckTest, WhatCrossesItsEpipolarLinesIsFound) {
  for (const View& view : {View{kRight_m, 0, {0, -0.05}},
                           View{kRight_m, 0.02, {0, -0.05}},
                           View{kForward_m, 0, {0.05, 0}},
                           View{{0.04, 0.02, 0.05}, 0.02, {0.03, -0.04}}}) {
    const Shares shares = Find(view);
    EXPECT_GT(shares.mover, 0.7) << view.at_m.transpose() << ", " << view.yaw_rad;
    EXPECT_LT(shares.others, 0.03) << view.at_m.transpose() << ", " << view.yaw_rad;
  }
}

// A limit of the published check.
TEST_F(EpipolarCheckTest, WhatMovesAlongItsEpipolarLinesIsNotFound) {
  const Shares shares = Find({kRight_m, 0, {0.05, 0}});
  EXPECT_LT(shares.mover, 0.07);
  EXPECT_LT(shares.others, 0.02);
}

TEST_F(EpipolarCheckTest, PointsAreFittedWithoutDistortion) {
  camera_ = MakeCamera(-0.3);
  EXPECT_LT(Find({kRight_m, 0.1}).others, 0.02);
  const Shares shares = Find({kRight_m, 0.1, {0, -0.05}});
  EXPECT_GT(shares.mover, 0.7);
  EXPECT_LT(shares.others, 0.03);
}

// The camera all but stands, so that each point is near its corner, and all points are reported.
TEST_F(EpipolarCheckTest, PointsAreReturnedAsSeen) {
  camera_ = MakeCamera(-0.3);
  options_.max_epipolar_px = 0;
  const Picture before = See(camera_, {});
  const auto points = Find(before, See(camera_, {{0, 0, 0}, 0.002}));
  EXPECT_GT(points.size(), 400U);
  for (const Eigen::Vector2f& point : points) {
    EXPECT_TRUE(std::ranges::any_of(
        before.frame.corners,
        [&](const Eigen::Vector2f& corner) { return Distance_px(point, corner) < 1.5; }))
        << point.x() << ", " << point.y();
  }
}

TEST_F(EpipolarCheckTest, PairsNearTheBorderAreDropped) {
  const Picture before = See(camera_, {});
  const Picture now = See(camera_, {kRight_m, 0, {0, -0.05}});
  const auto is_near = [](const Eigen::Vector2f& at) { return at.y() < 85; };
  EXPECT_TRUE(std::ranges::any_of(Find(before, now), is_near));
  options_.border_px = 85;
  const auto inside = Find(before, now);
  EXPECT_FALSE(inside.empty());
  EXPECT_FALSE(std::ranges::any_of(inside, is_near));
  options_.border_px = kHeight / 2;
  EXPECT_TRUE(Find(before, now).empty());
}

TEST_F(EpipolarCheckTest, PairsThatLookDifferentAreDropped) {
  const View brighter{kRight_m, 0, {0, -0.05}, 20};
  EXPECT_LT(Find(brighter).mover, 0.25);
  options_.max_patch_difference = 255;
  EXPECT_GT(Find(brighter).mover, 0.7);
}

TEST_F(EpipolarCheckTest, TooFewCornersSayNothing) {
  Picture before = See(camera_, {});
  const Picture now = See(camera_, {kRight_m, 0, {0, -0.05}});
  EXPECT_FALSE(Find(before, now).empty());
  options_.min_points = static_cast<int>(before.frame.corners.size()) + 1;
  EXPECT_TRUE(Find(before, now).empty());
  options_.min_points = 30;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  before.frame.corners.assign(100, {nan, 50});
  before.frame.corners.resize(200, {-1e9F, 1e9F});
  EXPECT_TRUE(Find(before, now).empty());
  before.frame.corners.assign(100, {160, 120});  // one corner, which has no fundamental matrix
  EXPECT_TRUE(Find(before, now).empty());
  before.frame.corners.clear();
  EXPECT_TRUE(Find(before, now).empty());
  before.frame.pyramid = {};
  EXPECT_TRUE(Find(before, now).empty());
}

// A camera that stands leaves the epipole open, so that each draw of RANSAC shows.
TEST_F(EpipolarCheckTest, TheSeedAloneDecidesWhateverOtherThreadsDraw) {
  const Picture before = See(camera_, {});
  const Picture now = See(camera_, {{0, 0, 0}, 0, {0.05, 0}});
  constexpr std::size_t kNumSeeds = 8;
  std::vector<std::vector<Eigen::Vector2f>> once, at_once(4 * kNumSeeds);
  for (std::size_t seed = 0; seed < kNumSeeds; ++seed) once.push_back(Find(before, now, seed));
  EXPECT_NE(once, std::vector(kNumSeeds, once[0]));
  ParallelFor(at_once.size(), 4, [&](std::size_t i) {
    cv::theRNG().state = 12345 * (i + 1);
    at_once[i] = Find(before, now, i % kNumSeeds);
  });
  for (std::size_t i = 0; i < at_once.size(); ++i) EXPECT_EQ(at_once[i], once[i % kNumSeeds]) << i;
}

TEST_F(EpipolarCheckTest, ARegionWithEnoughMovingPointsMoves) {
  Image<std::int32_t> regions{4, 2, 1, {0, 1, 2, 3, 0, 1, 2, 3}};
  options_.min_moving_points = 2;
  const std::vector<Eigen::Vector2f> points = {
      {0, 0}, {1.9F, 3}, {1, 1}, {2, 0}, {3.9F, 3.9F}, {4, 1}, {7, 3}, {6, 0}, {6, 1}};
  EXPECT_EQ(RegionsThatMove(options_, regions, 3, points), (std::vector<bool>{true, false, true}));
  options_.min_moving_points = 3;
  EXPECT_EQ(RegionsThatMove(options_, regions, 3, points), (std::vector<bool>{false, false, true}));
  EXPECT_EQ(RegionsThatMove(options_, regions, 3, {}), std::vector<bool>(3));
  EXPECT_TRUE(
      RegionsThatMove(options_, {4, 2, 1, std::vector<std::int32_t>(8)}, 0, points).empty());
}

// Labels decide of a region where the pictures say nothing.
TEST_F(EpipolarCheckTest, LabelsDecideWhereThereAreTooFewPairs) {
  const Picture before = See(camera_, {});
  Picture now = See(camera_, {kRight_m});
  now.frame.depth = {camera_.depth.width, camera_.depth.height, 1, {}};
  now.frame.depth.pixels.resize(camera_.depth_rays.size());
  LabelledRegions regions{{camera_.depth.width, camera_.depth.height, 1, {}}, 1};
  regions.of_pixel.pixels.resize(camera_.depth_rays.size());
  regions.of_pixel.pixels[7] = 1;
  const auto decide = [&](const SmallFrame* previous) {
    return PublishedDecision(options_, kWindow_px, camera_, previous, now.frame, regions, 1)
        .pixels[7];
  };
  EXPECT_EQ(decide(&before.frame), -1);
  EXPECT_EQ(decide(nullptr), 1);
  options_.min_points = 10000;
  EXPECT_FALSE(MovingPoints(options_, kWindow_px, camera_, before.frame, now.frame, 1));
  EXPECT_EQ(decide(&before.frame), 1);
}

}  // namespace nightmap::epipolar_check_test
