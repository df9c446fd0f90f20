// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_tracks/new_corners.h"

#include "tests/test_data.h"

namespace nightmap::new_corners_test {

using Pixels = std::vector<Eigen::Vector2f>;
const Camera kCamera{640, 480, 500, 500, 319.5, 239.5};  // cells of 80 x 80 pixels

// All corners in one cell first, then one in each cell.
Pixels Corners() {
  Pixels corners;
  for (int i = 0; i < 9; ++i) {
    corners.emplace_back(90.0F + static_cast<float>(25 * (i % 3)),
                         90.0F + static_cast<float>(25 * (i / 3)));
  }
  for (int i = 0; i < 48; ++i) {
    corners.emplace_back(static_cast<float>(80 * (i % 8) + 20),
                         static_cast<float>(80 * (i / 8) + 20));
  }
  return corners;
}

TEST(NewCorners, FillCellsBeforeTheyCrowdOne) {
  NewCornerOptions options;
  options.max_tracks = 50;
  const auto chosen = ChooseNewCorners(Corners(), {}, kCamera, options);
  ASSERT_EQ(chosen.size(), 50U);
  EXPECT_EQ(std::vector(chosen.begin(), chosen.begin() + 3), (std::vector{0, 1, 2}));
  EXPECT_EQ(chosen.back(), 56);
}

TEST(NewCorners, OnlyEmptyCellsGetOnesWhileThereAreEnoughTracks) {
  Pixels tracks = Corners();
  tracks.erase(tracks.begin() + 20);
  NewCornerOptions options;
  options.min_tracks = 56;
  EXPECT_EQ(ChooseNewCorners(Corners(), tracks, kCamera, options), std::vector{20});
}

TEST(NewCorners, KeepTheirDistance) {
  const Pixels tracks = {{100, 100}};
  NewCornerOptions options;
  options.min_distance_px = 12;
  EXPECT_TRUE(ChooseNewCorners({{111, 100}}, tracks, kCamera, options).empty());
  EXPECT_EQ(ChooseNewCorners({{113, 100}, {118, 100}}, tracks, kCamera, options), std::vector{0});
}

TEST(NewCorners, NoneFromNone) { EXPECT_TRUE(ChooseNewCorners({}, {}, kCamera, {}).empty()); }

}  // namespace nightmap::new_corners_test
