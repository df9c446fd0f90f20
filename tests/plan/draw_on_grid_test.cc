// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/draw_on_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/random.h"
#include "tests/small_grids.h"

namespace nightmap::draw_on_grid_test {

constexpr Rgb kWhite = {255, 255, 255};
constexpr Rgb kBlack = {40, 40, 40};
constexpr Rgb kGrey = {205, 205, 205};
constexpr Rgb kRed = {200, 0, 0};

Rgb At(const GridCanvas& canvas, int x, int y) {
  const ColorImage& picture = canvas.Picture();
  return {picture.At(x, y, 0), picture.At(x, y, 1), picture.At(x, y, 2)};
}

OccupancyGrid FreeGrid(int width, int height) {
  return nightmap::FreeGrid(width, height, 0.1, {-1, 2});
}

OccupancyGrid DrawGrid(Random& random, int width, int height) {
  OccupancyGrid grid = FreeGrid(width, height);
  for (auto& cell : grid.cells) cell = static_cast<std::uint8_t>(random.Index(3));
  return grid;
}

TEST(GridCanvas, EnlargedCellsAreSquaresWithYUp) {
  Random random(1);
  const OccupancyGrid grid = DrawGrid(random, 7, 5);
  const GridCanvas canvas(grid, 4, false);
  ASSERT_EQ(canvas.Picture().width, 28);
  ASSERT_EQ(canvas.Picture().height, 20);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 28; ++x) {
      const auto cell = grid.At({x / 4, (19 - y) / 4});
      EXPECT_EQ(At(canvas, x, y), (std::array{kWhite, kBlack, kGrey}[cell])) << x << ' ' << y;
    }
  }
}

// However much it is scaled down: every obstacle is seen, and nothing is black without one.
TEST(GridCanvas, ScaledDownNoObstacleIsLost) {
  for (const double scale : {0.9, 0.5, 0.3, 0.07}) {
    for (int seed = 0; seed < 20; ++seed) {
      Random random(static_cast<std::uint64_t>(seed));
      OccupancyGrid grid = FreeGrid(50, 40);
      const Eigen::Vector2i cell(static_cast<int>(random.Index(50)),
                                 static_cast<int>(random.Index(40)));
      grid.cells[grid.Index(cell.x(), cell.y())] = kOccupiedCell;
      const GridCanvas canvas(grid, scale, false);
      int num_black = 0;
      for (int y = 0; y < canvas.Picture().height; ++y) {
        for (int x = 0; x < canvas.Picture().width; ++x) {
          if (At(canvas, x, y) != kBlack) continue;
          ++num_black;
          const double below_y = canvas.Picture().height - 1 - y;
          EXPECT_LE(std::abs((x + 0.5) / scale - cell.x() - 0.5), 1 + 0.5 / scale);
          EXPECT_LE(std::abs((below_y + 0.5) / scale - cell.y() - 0.5), 1 + 0.5 / scale);
        }
      }
      EXPECT_GE(num_black, 1) << scale << ' ' << seed;
    }
  }
}

TEST(GridCanvas, ShapesAreWhereTheMapHasThem) {
  const OccupancyGrid grid = FreeGrid(60, 40);
  GridCanvas canvas(grid, 10, false);
  EXPECT_EQ(canvas.ToPixels(0.5), 50);
  canvas.Line({0.005, 3.005}, {2.005, 3.005}, kRed);
  canvas.Disc({3.005, 4.005}, 20, kRed);
  canvas.Ring({3.005, 5.005}, 20, kRed);
  EXPECT_EQ(At(canvas, 200, 299), kRed);    // 1 m right of the line's start
  EXPECT_EQ(At(canvas, 200, 303), kWhite);  // a line of one pixel
  EXPECT_EQ(At(canvas, 400, 199), kRed);    // middle of the disc
  EXPECT_EQ(At(canvas, 400, 185), kRed);
  EXPECT_EQ(At(canvas, 400, 175), kWhite);
  EXPECT_EQ(At(canvas, 400, 99), kWhite);  // middle of the ring
  EXPECT_EQ(At(canvas, 380, 99), kRed);
}

TEST(GridCanvas, TintHidesNothing) {
  OccupancyGrid grid = FreeGrid(60, 40);
  grid.cells[grid.Index(30, 20)] = kOccupiedCell;
  GridCanvas canvas(grid, 10, false);
  canvas.Line({1, 4.255}, {3, 4.255}, kRed);
  const ColorImage before = canvas.Picture();
  constexpr Rgb kBlue = {0, 0, 200};
  canvas.Tint({{2, 4}, {2.2, 4}}, 60, kBlue);
  int num_tinted = 0;
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 600; ++x) {
      const Rgb was = {before.At(x, y, 0), before.At(x, y, 1), before.At(x, y, 2)};
      const double off_px = std::hypot(std::clamp(x, 300, 320) - x, y - 200);
      if (was != kWhite || off_px > 62) {
        EXPECT_EQ(At(canvas, x, y), was) << x << ' ' << y;
      } else if (off_px < 58) {
        EXPECT_EQ(At(canvas, x, y), kBlue) << x << ' ' << y;
      }
      num_tinted += At(canvas, x, y) == kBlue ? 1 : 0;
    }
  }
  EXPECT_GT(num_tinted, 11000);
}

TEST(GridCanvas, WhatIsFarOutsideIsCutOff) {
  const OccupancyGrid grid = FreeGrid(20, 20);
  GridCanvas canvas(grid, 5, true);
  const ColorImage before = canvas.Picture();
  canvas.Disc({1e12, -1e12}, 5, kRed);
  canvas.Line({1e12, 0}, {1e13, 0}, kRed);
  EXPECT_EQ(canvas.Picture().pixels, before.pixels);
}

TEST(GridCanvas, ScaleBarHasTheLengthItSays) {
  const OccupancyGrid grid = FreeGrid(400, 300);  // 40 m: the bar is 10 m
  GridCanvas canvas(grid, 3, false);
  canvas.ScaleBar(kRed);
  int length_px = 0;
  for (int x = 0; x < canvas.Picture().width; ++x) length_px += At(canvas, x, 892) == kRed ? 1 : 0;
  EXPECT_NEAR(length_px, canvas.ToPixels(10), 6);  // it has round ends, 3 px thick
}

TEST(GridCanvas, LabelsStayInThePicture) {
  const OccupancyGrid grid = FreeGrid(40, 40);
  const auto num_red = [&](const Eigen::Vector2d& point) {
    GridCanvas canvas(grid, 5, false);
    canvas.Label(point, 3, 3, "goal", kRed);
    int count = 0;
    for (int y = 0; y < 200; ++y) {
      for (int x = 0; x < 200; ++x) count += At(canvas, x, y)[1] < 128 ? 1 : 0;
    }
    return count;
  };
  const int num_whole = num_red({1, 4});
  EXPECT_GT(num_whole, 20);
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(-1, 2), {3, 2}, {-1, 6}, {3, 6}}) {
    EXPECT_EQ(num_red(corner), num_whole);
  }
}

TEST(GridCanvas, CopiesAreDrawnOnApart) {
  const OccupancyGrid grid = FreeGrid(20, 20);
  GridCanvas canvas(grid, 5, false);
  GridCanvas copy = canvas;
  copy.Disc({0, 3}, 10, kRed);
  EXPECT_EQ(At(copy, 50, 49), kRed);
  EXPECT_EQ(At(canvas, 50, 49), kWhite);
}

}  // namespace nightmap::draw_on_grid_test
