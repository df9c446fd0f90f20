// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/move_off_obstacles.h"

#include <gtest/gtest.h>

#include "stages/plan/drive/path_track.h"
#include "tests/stages/plan/drive/random_path.h"

namespace nightmap::path_track_test {

TEST(MoveOffObstacles, MakesRoomWithoutGoingFar) {
  constexpr double kMargin_m = 0.02;
  int num_tight = 0;
  int num_roomy = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Random random(seed);
    const OccupancyGrid grid = RandomBuilding(random);
    const ClearanceMap map(grid, {0.2, true});
    const std::vector<Eigen::Vector2d> path = RandomPaths(grid, 0.2).Draw(random);
    if (path.empty()) continue;
    const PathTrack track(path);
    const std::vector<Eigen::Vector2d> moved = MoveOffObstacles(map, path, kMargin_m);
    EXPECT_EQ(moved.front(), path.front());
    EXPECT_LT((moved.back() - path.back()).norm(), 1e-12);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const double along = static_cast<double>(i) / static_cast<double>(moved.size() - 1);
      const Eigen::Vector2d before = track.At(along * track.Length_m());
      const double room_m = map.Room_m(before);
      const double moved_room_m = map.Room_m(moved[i]);
      EXPECT_LE((moved[i] - before).norm(), kMargin_m + 1e-9) << seed;
      EXPECT_GE(moved_room_m, room_m - 1e-9) << seed;
      if (room_m >= kMargin_m) {
        EXPECT_LT((moved[i] - before).norm(), 1e-12) << seed;
      }
      num_tight += room_m < 0.5 * kMargin_m ? 1 : 0;
      num_roomy += room_m < 0.5 * kMargin_m && moved_room_m > 0.9 * kMargin_m ? 1 : 0;
    }
  }
  EXPECT_GT(num_tight, 100);
  EXPECT_GT(num_roomy, num_tight / 2);
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

}  // namespace nightmap::path_track_test
