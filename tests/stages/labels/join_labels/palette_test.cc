// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/join_labels/palette.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::palette_test {

TEST(Palette, IsThatOfPascalVocUnlessGiven) {
  const auto voc = MakePalette({}, 16);
  ASSERT_EQ(voc.size(), 16U);
  EXPECT_EQ(voc[0], (Rgb{0, 0, 0}));
  EXPECT_EQ(voc[1], (Rgb{128, 0, 0}));
  EXPECT_EQ(voc[2], (Rgb{0, 128, 0}));
  EXPECT_EQ(voc[15], (Rgb{192, 128, 128}));
  EXPECT_EQ(MakePalette({"#000000", "#ff8001", "#0A0b0C"}, 3),
            (std::vector<Rgb>{{0, 0, 0}, {255, 128, 1}, {10, 11, 12}}));
}

TEST(Palette, HasNoWhiteWhichMeansNoColor) {
  EXPECT_EQ(MakePalette({"#ffffff", "#FFFFFF"}, 2),
            (std::vector<Rgb>{{255, 255, 254}, {255, 255, 254}}));
}

TEST(Palette, MustHaveAColorPerClass) {
  NIGHTMAP_EXPECT_ERROR(UsageError, MakePalette({"#000000"}, 3), "1 colors for 3 classes");
  for (const std::string color : {"000000", "#00000", "#0000000", "#00000g", "#-00001", "red"}) {
    NIGHTMAP_EXPECT_ERROR(UsageError,
                          MakePalette({"#000000", color}, 2),
                          "\"" + color + "\" is no color; write \"#rrggbb\"");
  }
}

}  // namespace nightmap::palette_test
