// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/random.h"
#include "tests/io/some_frames.h"
#include "tests/test_data.h"

namespace nightmap::register_depth_test {

DepthImage Plane(const Camera& camera, float depth_m) {
  const auto num_pixels = static_cast<std::size_t>(camera.width * camera.height);
  return {camera.width, camera.height, 1, std::vector<float>(num_pixels, depth_m)};
}

TEST(RegisterDepth, EqualCamerasInOnePlaceChangeNothing) {
  RgbdCamera camera = UnregisteredCamera();
  camera.depth = camera.color = SomeCamera().color;  // distortion included
  DepthImage depth = Plane(camera.depth, 0);
  Random random(1);
  for (float& pixel : depth.pixels) pixel = static_cast<float>(random.Uniform(0.5, 4));
  const DepthImage registered = RegisterDepth(depth, camera);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      // Rounding may put a border pixel a hair outside; everything else stays.
      if (x == 0 || y == 0 || x == depth.width - 1 || y == depth.height - 1) continue;
      ASSERT_FLOAT_EQ(registered.At(x, y), depth.At(x, y)) << x << " " << y;
    }
  }
}

TEST(RegisterDepth, PlaneStaysAPlaneWithoutPinholesInAFinerColorImage) {
  RgbdCamera camera = UnregisteredCamera();
  camera.color_from_depth.translation = {0.05, -0.02, 0.1};
  const DepthImage registered = RegisterDepth(Plane(camera.depth, 1.5f), camera);
  for (int y = 10; y < 50; ++y) {
    for (int x = 15; x < 65; ++x) {
      ASSERT_NEAR(registered.At(x, y), 1.6f, 1e-5) << x << " " << y;
    }
  }
}

TEST(RegisterDepth, PointsMoveByTheParallax) {
  RgbdCamera camera = UnregisteredCamera();
  camera.color = camera.depth;
  camera.color_from_depth.translation = {0.2, 0, 0};
  DepthImage depth = Plane(camera.depth, 0);
  depth.At(10, 12) = 1.0f;
  const DepthImage registered = RegisterDepth(depth, camera);
  EXPECT_FLOAT_EQ(registered.At(17, 12), 1.0f);  // 35 px * 0.2 m / 1 m = 7 px
  EXPECT_EQ(std::ranges::count(registered.pixels, 0.0f),
            static_cast<std::ptrdiff_t>(registered.pixels.size()) - 1);
}

TEST(RegisterDepth, TheNearestOfSeveralWins) {
  RgbdCamera camera = UnregisteredCamera();
  camera.color = camera.depth;
  camera.color_from_depth.translation = {0.2, 0, 0};
  for (const bool near_first : {true, false}) {
    DepthImage depth = Plane(camera.depth, 0);
    // Parallax 7 px at 1 m and 3.5 px at 2 m: 10 + 7 = 13.5 + 3.5 px, rounded to the same pixel.
    depth.At(10, near_first ? 12 : 13) = 1.0f;
    depth.At(13, near_first ? 12 : 13) = 2.0f;
    depth.At(14, near_first ? 12 : 13) = 2.0f;
    const DepthImage registered = RegisterDepth(depth, camera);
    EXPECT_FLOAT_EQ(registered.At(17, near_first ? 12 : 13), 1.0f);
  }
}

}  // namespace nightmap::register_depth_test
