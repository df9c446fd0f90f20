// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/keypoint_depth.h"

#include <algorithm>
#include <functional>

#include "tests/test_data.h"

namespace nightmap::keypoint_depth_test {

// Depth at a pixel of the image as taken, looked up in a window of 5 x 5 pixels.
float DepthAt(const std::function<float(int, int)>& depth_m,
              const Eigen::Vector2f& raw_px = {10.2F, 9.8F}) {
  DepthImage depth{20, 20, 1, std::vector<float>(400)};
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) depth.At(x, y) = depth_m(x, y);
  }
  FrameFeatures features;
  features.raw_keypoints_px = {raw_px};
  features.keypoints_px = {{3, 3}};  // undistorted: the depth image is not
  features.depths_m = {0};
  LookUpDepth(depth, &features);
  return features.depths_m[0];
}

TEST(LookUpDepth, IsTheMeanOfASmoothSurface) {
  EXPECT_FLOAT_EQ(DepthAt([](int, int) { return 2.0F; }), 2.0F);
  EXPECT_NEAR(
      DepthAt([](int x, int) { return 2.0F + 0.01F * static_cast<float>(x - 10); }), 2, 1e-5);
}

// Nothing is measured beside the keypoint, so one pixel of the far side would be a second surface.
TEST(LookUpDepth, AWindowOverTheBorderEndsThere) {
  const auto halves = [](int x, int) { return x == 0 || x == 19 ? 0.0F : x < 10 ? 2.0F : 5.0F; };
  EXPECT_FLOAT_EQ(DepthAt(halves, {-0.4F, 10}), 2.0F);
  EXPECT_FLOAT_EQ(DepthAt(halves, {19.4F, 10}), 5.0F);
  EXPECT_FLOAT_EQ(DepthAt(halves, {0, 0}), 2.0F);
  EXPECT_FLOAT_EQ(DepthAt(halves, {19, 19}), 5.0F);
}

TEST(LookUpDepth, NeverMixesTwoSurfaces) {
  EXPECT_FLOAT_EQ(DepthAt([](int x, int) { return x <= 10 ? 1.0F : 3.0F; }), 1.0F);
  EXPECT_FLOAT_EQ(DepthAt([](int x, int) { return x < 10 ? 1.0F : 3.0F; }), 3.0F);
}

TEST(LookUpDepth, BridgesAHoleInOneSurfaceButNotAtAnEdge) {
  const auto hole = [](int x, int y) { return std::abs(x - 10) <= 1 && std::abs(y - 10) <= 1; };
  EXPECT_FLOAT_EQ(DepthAt([&](int x, int y) { return hole(x, y) ? 0.0F : 2.0F; }), 2.0F);
  EXPECT_EQ(DepthAt([&](int x, int y) { return hole(x, y) ? 0.0F : x <= 10 ? 1.0F : 3.0F; }), 0.0F);
  EXPECT_EQ(DepthAt([](int, int) { return 0.0F; }), 0.0F);
}

// The office recording: the centre is measured, a ring around it is not.
TEST(LookUpDepth, TheCentreOfARingCounts) {
  EXPECT_FLOAT_EQ(DepthAt([](int x, int y) {
                    const int ring = std::max(std::abs(x - 10), std::abs(y - 10));
                    return ring == 0 ? 2.0F : ring == 1 ? 0.0F : 2.02F;
                  }),
                  (2.0F + 16 * 2.02F) / 17);
}

}  // namespace nightmap::keypoint_depth_test
