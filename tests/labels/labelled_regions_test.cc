// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/labelled_regions.h"

#include <gtest/gtest.h>

namespace nightmap::labelled_regions_test {

std::vector<std::int32_t> RegionsOfRow(const std::vector<std::uint8_t>& may_move,
                                       const std::vector<float>& depth_m) {
  const int width = static_cast<int>(may_move.size());
  const LabelledRegions regions =
      FindLabelledRegions({width, 1, 1, may_move}, {width, 1, 1, depth_m});
  EXPECT_EQ(regions.num, *std::ranges::max_element(regions.of_pixel.pixels));
  return regions.of_pixel.pixels;
}

using Row = std::vector<std::int32_t>;

TEST(LabelledRegionsTest, NeighboursOfOneDepthAreOneRegion) {
  EXPECT_EQ(RegionsOfRow({0, 255, 255, 0, 255}, {1, 1, 1.05, 1, 1}), (Row{0, 1, 1, 0, 2}));
}

TEST(LabelledRegionsTest, AStepOfDepthParts) {
  EXPECT_EQ(RegionsOfRow({255, 255, 255}, {1, 1.2, 1.21}), (Row{1, 2, 2}));
}

TEST(LabelledRegionsTest, AShadowWithoutDepthDoesNotJoin) {
  EXPECT_EQ(RegionsOfRow({255, 255, 255, 255}, {1, 0, 0, 2}), (Row{1, 1, 1, 2}));
}

TEST(LabelledRegionsTest, WithoutLabelsThereIsNone) {
  EXPECT_EQ(RegionsOfRow({0, 0}, {1, 1}), (Row{0, 0}));
  EXPECT_EQ(FindLabelledRegions({}, {2, 1, 1, {1, 1}}).num, 0);
}

TEST(LabelledRegionsTest, ARingIsOneRegion) {
  const GrayImage ring{3, 3, 1, {1, 1, 1, 1, 0, 1, 1, 1, 1}};
  EXPECT_EQ(FindLabelledRegions(ring, {3, 3, 1, std::vector<float>(9, 2)}).num, 1);
}

}  // namespace nightmap::labelled_regions_test
