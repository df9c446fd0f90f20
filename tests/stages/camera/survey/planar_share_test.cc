// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/planar_share.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/random.h"

namespace nightmap::planar_share_test {

const Camera kCamera{.width = 320, .height = 240, .fx = 260, .fy = 260, .cx = 159.5, .cy = 119.5};

// A floor below a camera that looks down a little, and a box that stands on it.
DepthImage Floor(bool is_along_ray, std::uint64_t seed) {
  Random random(seed);
  const double pitch_rad = random.Uniform(0.4, 0.9);
  DepthImage depth{320, 240, 1, std::vector<float>(320 * 240)};
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const Eigen::Vector3d ray = kCamera.BackProject(Eigen::Vector2d(x, y), 1);
      const double down = std::sin(pitch_rad) + ray.y() * std::cos(pitch_rad);
      double z = down > 0.1 ? 1.3 / down : 0;
      if (x > 120 && x < 180 && y > 60 && y < 150) z = 1.2;
      z *= 1 + 0.003 * random.Gaussian();
      depth.At(x, y) = static_cast<float>(is_along_ray ? z * ray.norm() : z);
    }
  }
  return depth;
}

TEST(PlanarShares, AFloorIsFlatAsWhatItsDepthIs) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto z = MeasurePlanarShares(Floor(false, seed), kCamera, false, seed);
    EXPECT_GT(z.as_declared, 0.6) << seed;
    EXPECT_LT(z.otherwise, 0.8 * z.as_declared) << seed;
    const auto ray = MeasurePlanarShares(Floor(true, seed), kCamera, false, seed);
    EXPECT_GT(ray.otherwise, 0.6) << seed;
    EXPECT_LT(ray.as_declared, 0.8 * ray.otherwise) << seed;
  }
}

// Declared along the ray, the loader has divided by the ray's length.
TEST(PlanarShares, ZThatIsDeclaredAsDistancesIsSeen) {
  DepthImage depth = Floor(false, 1);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      depth.At(x, y) /= static_cast<float>(kCamera.BackProject(Eigen::Vector2d(x, y), 1).norm());
    }
  }
  const auto shares = MeasurePlanarShares(depth, kCamera, true, 1);
  EXPECT_GT(shares.otherwise, 0.6);
  EXPECT_LT(shares.as_declared, 0.8 * shares.otherwise);
}

TEST(PlanarShares, WithoutDepthThereIsNone) {
  const DepthImage depth{320, 240, 1, std::vector<float>(320 * 240)};
  const auto shares = MeasurePlanarShares(depth, kCamera, false, 1);
  EXPECT_EQ(shares.as_declared, 0);
  EXPECT_EQ(shares.otherwise, 0);
}

}  // namespace nightmap::planar_share_test
