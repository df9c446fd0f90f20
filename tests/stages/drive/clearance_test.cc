// SPDX-License-Identifier: Apache-2.0
#include "stages/drive/clearance.h"

#include <gtest/gtest.h>

#include "stages/drive/path_track.h"
#include "tests/stages/drive/random_path.h"

namespace nightmap {
namespace {

TEST(Clearance, IsTheDistanceToTheNearestSquare) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Random random(seed);
    const OccupancyGrid grid = RandomBuilding(random, 80);
    const ClearanceMap map(grid, {0.25, true});
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d point = grid.origin_in_map + Eigen::Vector2d(random.Uniform(-0.5, 4.5),
                                                                         random.Uniform(-0.5, 4.5));
      const double plain_m = PlainClearance_m(grid, point);
      const double clearance_m = map.Clearance_m(point);
      if (plain_m < ClearanceMap::kFar_m) {
        EXPECT_NEAR(clearance_m, plain_m, 1e-9) << seed;
      } else {
        EXPECT_GE(clearance_m, ClearanceMap::kFar_m) << seed;
        EXPECT_LE(clearance_m, plain_m) << seed;
      }
      EXPECT_EQ(map.IsClear(point), plain_m >= map.MinClearance_m()) << seed;
    }
  }
}

TEST(Clearance, UnknownAndOutsideAreObstaclesOnlyWhenTheyAreToBe) {
  OccupancyGrid grid{10, 10, 0.1, {0, 0}, {}};
  grid.cells.assign(100, kFreeCell);
  grid.cells[grid.Index(5, 5)] = kUnknownCell;
  const ClearanceMap strict(grid, {0.1, true});
  EXPECT_NEAR(strict.Clearance_m({0.55, 0.45}), 0.05, 1e-9);
  EXPECT_NEAR(strict.Clearance_m({0.05, 0.5}), 0.05, 1e-9);
  EXPECT_EQ(strict.Clearance_m({-0.5, 3}), 0);
  const ClearanceMap lax(grid, {0.1, false});
  EXPECT_GE(lax.Clearance_m({0.55, 0.45}), ClearanceMap::kFar_m);
  EXPECT_GE(lax.Clearance_m({-0.5, 3}), ClearanceMap::kFar_m);
}

TEST(PathTrack, NearestIsThatOfDenseSamples) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    std::vector<Eigen::Vector2d> points;
    for (int k = 0; k < 8; ++k) {
      points.emplace_back(random.Uniform(-1, 1), random.Uniform(-1, 1));
      if (k % 3 == 0) points.push_back(points.back());  // repeated
    }
    const PathTrack track(points);
    const double from_m = random.Uniform(0, track.Length_m());
    const double to_m = random.Uniform(from_m, track.Length_m());
    const Eigen::Vector2d point(random.Uniform(-1, 1), random.Uniform(-1, 1));
    double dense_m = 10;
    for (int k = 0; k <= 5000; ++k) {
      dense_m = std::min(dense_m, (track.At(from_m + (to_m - from_m) * k / 5000) - point).norm());
    }
    const double nearest_m = track.Nearest_m(point, from_m, to_m);
    EXPECT_GE(nearest_m, from_m - 1e-12);
    EXPECT_LE(nearest_m, to_m + 1e-12);
    EXPECT_LE((track.At(nearest_m) - point).norm(), dense_m + 1e-12);
    EXPECT_GE((track.At(nearest_m) - point).norm(), dense_m - 1e-3);
  }
}

TEST(PathTrack, OnePointIsATrackToo) {
  const PathTrack track({{1, 2}, {1, 2}});
  EXPECT_EQ(track.Length_m(), 0);
  EXPECT_EQ(track.At(3), Eigen::Vector2d(1, 2));
  EXPECT_EQ(track.Nearest_m({5, 5}, 0, 0), 0);
}

}  // namespace
}  // namespace nightmap
