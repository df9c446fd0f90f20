// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/distance_transform.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"

namespace nightmap::distance_transform_test {

struct Mask {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> blocked;
};

Mask RandomMask(std::uint64_t seed, double density) {
  Random random(seed);
  Mask mask{1 + static_cast<int>(random.Index(30)), 1 + static_cast<int>(random.Index(30)), {}};
  for (int i = 0; i < mask.width * mask.height; ++i) {
    mask.blocked.push_back(random.Uniform() < density ? 1 : 0);
  }
  return mask;
}

int BruteForce(const Mask& mask, int x, int y, bool outside_blocked) {
  int best = 1 << 30;
  for (int v = -1; v <= mask.height; ++v) {
    for (int u = -1; u <= mask.width; ++u) {
      const bool inside = u >= 0 && v >= 0 && u < mask.width && v < mask.height;
      const bool blocked = inside ? mask.blocked[static_cast<std::size_t>(v * mask.width + u)] != 0
                                  : outside_blocked;
      if (blocked) best = std::min(best, (u - x) * (u - x) + (v - y) * (v - y));
    }
  }
  return best;
}

TEST(DistanceTransform, EqualsBruteForce) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const double density = seed % 3 == 0 ? 0.01 : seed % 3 == 1 ? 0.1 : 0.6;
    const Mask mask = RandomMask(seed, density);
    const bool any = std::count(mask.blocked.begin(), mask.blocked.end(), 1) > 0;
    for (const bool outside : {false, true}) {
      if (!any && !outside) continue;
      const auto distances = SquaredDistances(mask.blocked, mask.width, mask.height, outside, 1);
      for (int y = 0; y < mask.height; ++y) {
        for (int x = 0; x < mask.width; ++x) {
          ASSERT_EQ(distances[static_cast<std::size_t>(y * mask.width + x)],
                    BruteForce(mask, x, y, outside))
              << "seed " << seed << " cell " << x << "," << y << " outside " << outside;
        }
      }
    }
  }
}

TEST(DistanceTransform, WithoutObstaclesEverythingIsFar) {
  const auto distances = SquaredDistances(std::vector<std::uint8_t>(60, 0), 10, 6, false, 1);
  EXPECT_GE(*std::min_element(distances.begin(), distances.end()), 100);
}

TEST(DistanceTransform, ThreadsDoNotMatter) {
  Random random(5);
  std::vector<std::uint8_t> blocked(300 * 200);
  for (auto& cell : blocked) cell = random.Uniform() < 0.01 ? 1 : 0;
  EXPECT_EQ(SquaredDistances(blocked, 300, 200, true, 1),
            SquaredDistances(blocked, 300, 200, true, 4));
}

TEST(DistanceTransform, RefusesSidesThatOverflow) {
  EXPECT_THROW(SquaredDistances(std::vector<std::uint8_t>(46341), 46341, 1, false, 1), DataError);
}

}  // namespace nightmap::distance_transform_test
