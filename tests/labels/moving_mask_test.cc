// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/moving_mask.h"

#include <cmath>

#include "tests/test_data.h"

namespace nightmap::moving_mask_test {

constexpr int kWidth = 30, kHeight = 20;
const LabelClasses kClasses{{"floor", "person", "chair"}, {0, 1, 0}};

// A person of one pixel at (10, 8), and a chair beside it.
Segmentation OnePerson(std::uint8_t confidence) {
  Segmentation segmentation{{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 0)},
                            {kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 255)}};
  segmentation.labels.At(10, 8) = 1;
  segmentation.labels.At(20, 8) = 2;
  segmentation.confidences.At(10, 8) = confidence;
  return segmentation;
}

TEST(MovingMask, HoldsClassesThatMoveAndTheirMargin) {
  for (const int margin_px : {0, 1, 4}) {
    const GrayImage mask = MovingMask(OnePerson(200), kClasses, {0.5, margin_px});
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double distance_px = std::hypot(x - 10, y - 8);
        if (distance_px <= margin_px - 0.5 || distance_px == 0) {
          EXPECT_EQ(mask.At(x, y), 255) << x << " " << y;
        } else if (distance_px > margin_px + 0.5) {
          EXPECT_EQ(mask.At(x, y), 0) << x << " " << y;
        }
      }
    }
  }
}

TEST(MovingMask, LeavesOutWhatIsNotProbableEnough) {
  const auto num_masked = [](std::uint8_t confidence, double min_confidence) {
    const GrayImage mask = MovingMask(OnePerson(confidence), kClasses, {min_confidence, 0});
    return std::ranges::count(mask.pixels, std::uint8_t{255});
  };
  EXPECT_EQ(num_masked(127, 0.5), 0);
  EXPECT_EQ(num_masked(128, 0.5), 1);
  EXPECT_EQ(num_masked(0, 0), 1);
  EXPECT_EQ(num_masked(254, 1), 0);
  EXPECT_EQ(num_masked(255, 1), 1);
}

}  // namespace nightmap::moving_mask_test
