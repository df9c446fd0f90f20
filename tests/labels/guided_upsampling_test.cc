// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/guided_upsampling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/random.h"

namespace nightmap::guided_upsampling_test {

constexpr int kWidth = 200;
constexpr int kHeight = 120;
constexpr int kEdge = 103;  // first column of the right half

ColorImage Picture(std::uint8_t left, std::uint8_t right) {
  ColorImage image{kWidth, kHeight, 3, std::vector<std::uint8_t>(3 * kWidth * kHeight)};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) image.At(x, y, c) = x < kEdge ? left : right;
    }
  }
  return image;
}

DepthImage Depth(float left_m, float right_m) {
  DepthImage depth{kWidth, kHeight, 1, std::vector<float>(kWidth * kHeight)};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) depth.At(x, y) = x < kEdge ? left_m : right_m;
  }
  return depth;
}

// 50 x 30: a soft step whose middle is two small pixels, eight of the picture, left of the edge.
Plane SoftStep() {
  Plane plane{50, 30, 1, {}};
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 50; ++x) {
      plane.pixels.push_back(1 / (1 + std::exp(-(static_cast<float>(x) - 23.5F) / 1.5F)));
    }
  }
  return plane;
}

// Mean over the rows of the number of pixels on the wrong side of 0.5.
double MeanError_px(const Plane& plane) {
  int num_wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) num_wrong += (plane.At(x, y) > 0.5F) != (x >= kEdge);
  }
  return static_cast<double>(num_wrong) / kHeight;
}

TEST(GuidedUpsampling, AStepMovesToTheEdgeOfColor) {
  EXPECT_LT(MeanError_px(UpsampleAlongEdges({SoftStep()}, Picture(60, 200), {})[0]), 1);
  EXPECT_GT(MeanError_px(UpsampleAlongEdges({SoftStep()}, Picture(100, 100), {})[0]), 5);
}

TEST(GuidedUpsampling, AStepMovesToTheEdgeOfDepthEvenWithHoles) {
  DepthImage depth = Depth(3, 1);
  EXPECT_LT(MeanError_px(UpsampleAlongEdges({SoftStep()}, Picture(100, 100), depth)[0]), 1);
  Random random(1);
  for (float& depth_m : depth.pixels) {
    if (random.Index(3) == 0) depth_m = 0;
  }
  EXPECT_LT(MeanError_px(UpsampleAlongEdges({SoftStep()}, Picture(100, 100), depth)[0]), 2);
}

TEST(GuidedUpsampling, WithoutAnyDepthTheResultIsThatOfColor) {
  const ColorImage picture = Picture(60, 200);
  const auto with = UpsampleAlongEdges({SoftStep()}, picture, Depth(0, 0));
  const auto without = UpsampleAlongEdges({SoftStep()}, picture, {});
  EXPECT_EQ(with[0].pixels, without[0].pixels);
}

TEST(GuidedUpsampling, PlanesThatSumToOneStillDo) {
  Plane rest = SoftStep();
  for (float& value : rest.pixels) value = 1 - value;
  const auto planes = UpsampleAlongEdges({SoftStep(), rest}, Picture(60, 200), Depth(3, 1));
  ASSERT_EQ(planes[0].width, kWidth);
  ASSERT_EQ(planes[0].height, kHeight);
  for (std::size_t i = 0; i < planes[0].pixels.size(); ++i) {
    ASSERT_NEAR(planes[0].pixels[i] + planes[1].pixels[i], 1, 1e-3);
  }
}

TEST(GuidedUpsampling, APictureSmallerThanThePlanesIsFilledToo) {
  const ColorImage tiny{8, 6, 3, std::vector<std::uint8_t>(3 * 8 * 6, 90)};
  const auto planes = UpsampleAlongEdges({SoftStep()}, tiny, {});
  ASSERT_EQ(planes[0].pixels.size(), 48U);
  EXPECT_LT(planes[0].At(0, 3), 0.1F);
  EXPECT_GT(planes[0].At(7, 3), 0.9F);
}

}  // namespace nightmap::guided_upsampling_test
