// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/exif_lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace nightmap::exif_lens_test {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(ExifLens, The35mmEquivalentIsOfTheDiagonal) {
  // Film itself: 36 mm are as many pixels as the picture is wide.
  EXPECT_NEAR(*FocalLength_px({.focal_35mm_mm = 36}, 3600, 2400), 3600, 1e-9);
  EXPECT_NEAR(*FocalLength_px({.focal_35mm_mm = 36}, 2400, 3600), 3600, 1e-9);
  // A phone of 4:3, "26 mm", has 67.3 degrees across its longer side.
  const double focal_px = *FocalLength_px({.focal_35mm_mm = 26}, 4032, 3024);
  EXPECT_NEAR(2 * std::atan(4032 / 2 / focal_px) * 180 / 3.14159265, 67.3, 0.1);
}

TEST(ExifLens, FocalLengthAndSensorResolution) {
  // 50 mm on a sensor of 36 mm with 6000 pixels, in each unit.
  const double expected_px = 50 * 6000 / 36.0;
  const double per_mm = 6000 / 36.0;
  for (const auto& [unit, per_unit] : {std::pair{2, per_mm * 25.4},
                                       std::pair{3, per_mm * 10},
                                       std::pair{4, per_mm},
                                       std::pair{5, per_mm / 1000}}) {
    const ExifLens lens{.focal_mm = 50, .plane_pixels_per_unit = per_unit, .plane_unit = unit};
    EXPECT_NEAR(FocalLength_px(lens, 6000, 4000).value_or(0), expected_px, 1e-6) << unit;
  }
  EXPECT_FALSE(FocalLength_px({.focal_mm = 50, .plane_pixels_per_unit = 1, .plane_unit = 1}, 9, 9));
  // Scaled down since, and rotated upright.
  const ExifLens whole{
      .focal_mm = 50, .plane_pixels_per_unit = per_mm, .plane_unit = 4, .longer_side_px = 6000};
  EXPECT_NEAR(FocalLength_px(whole, 1500, 1000).value_or(0), expected_px / 4, 1e-6);
  EXPECT_NEAR(FocalLength_px(whole, 1000, 1500).value_or(0), expected_px / 4, 1e-6);
}

TEST(ExifLens, The35mmEquivalentComesFirst) {
  const ExifLens lens{.focal_35mm_mm = 36, .focal_mm = 4, .plane_pixels_per_unit = 100};
  EXPECT_NEAR(*FocalLength_px(lens, 3600, 2400), 3600, 1e-9);
}

TEST(ExifLens, WhatIsNoPositiveNumberIsNotKnown) {
  EXPECT_FALSE(FocalLength_px({}, 640, 480));
  EXPECT_FALSE(FocalLength_px({.focal_mm = 50}, 640, 480));
  EXPECT_FALSE(FocalLength_px({.plane_pixels_per_unit = 50}, 640, 480));
  for (const double bad : {0.0, -1.0, kNaN, kInfinity}) {
    EXPECT_FALSE(FocalLength_px({.focal_35mm_mm = bad}, 640, 480)) << bad;
    EXPECT_FALSE(FocalLength_px({.focal_mm = bad, .plane_pixels_per_unit = 9}, 640, 480)) << bad;
    EXPECT_FALSE(FocalLength_px({.focal_mm = 9, .plane_pixels_per_unit = bad}, 640, 480)) << bad;
    // A useless equivalent hides no other data, and a useless size means none was made smaller.
    const ExifLens lens{.focal_35mm_mm = bad,
                        .focal_mm = 5,
                        .plane_pixels_per_unit = 254,
                        .plane_unit = 2,
                        .longer_side_px = bad};
    EXPECT_NEAR(FocalLength_px(lens, 640, 480).value_or(0), 50, 1e-9) << bad;
  }
}

}  // namespace nightmap::exif_lens_test
