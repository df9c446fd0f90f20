// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/refine_corner.h"

#include <cmath>
#include <functional>
#include <vector>

#include "tests/test_data.h"

namespace nightmap::refine_corner_test {

constexpr int kSize_px = 40;

// A point's value, seen through a lens that blurs it a little: the mean of 20 x 20 points.
class Picture {
 public:
  explicit Picture(const std::function<double(double x, double y)>& gray_at) {
    for (int y = 0; y < kSize_px; ++y) {
      for (int x = 0; x < kSize_px; ++x) {
        double sum = 0;
        for (int k = 0; k < 400; ++k) {
          sum += gray_at(x + (k % 20 - 9.5) / 10.0, y + (k / 20 - 9.5) / 10.0);
        }
        pixels_.push_back(static_cast<std::uint8_t>(std::lround(sum / 400)));
      }
    }
  }
  GrayView View() const { return {pixels_.data(), kSize_px, kSize_px, kSize_px}; }

 private:
  std::vector<std::uint8_t> pixels_;
};

TEST(RefineCorner, FindsSaddlesFromPixelsAround) {
  for (const double angle_rad : {0.0, 0.3, 0.8, 1.5}) {
    const Eigen::Vector2f corner(20.37F, 19.81F);
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    const Picture picture([&](double x, double y) {
      const double u = x - static_cast<double>(corner.x()), v = y - static_cast<double>(corner.y());
      return (c * u + s * v > 0) == (c * v - s * u > 0) ? 180.0 : 60.0;
    });
    for (const Eigen::Vector2f& start :
         std::vector<Eigen::Vector2f>{{20, 20}, {19, 21}, {21.5F, 19}}) {
      const auto found = RefineCorner(picture.View(), start, 4, 3);
      ASSERT_TRUE(found) << angle_rad;
      EXPECT_LT((*found - corner).norm(), 0.07F) << angle_rad;
    }
  }
}

TEST(RefineCorner, AnEdgeAndABlankAreNoCorners) {
  const Picture edge([](double x, double y) { return x + 0.4 * y > 28 ? 200.0 : 50.0; });
  EXPECT_FALSE(RefineCorner(edge.View(), {20, 20}, 4, 3));
  const Picture blank([](double, double) { return 255.0; });
  EXPECT_FALSE(RefineCorner(blank.View(), {20, 20}, 4, 3));
}

TEST(RefineCorner, NothingBeyondTheLongestWayAndAtTheBorder) {
  const Picture picture([](double x, double y) { return (x > 20) == (y > 20) ? 180.0 : 60.0; });
  EXPECT_TRUE(RefineCorner(picture.View(), {22, 20}, 4, 2.5));
  EXPECT_FALSE(RefineCorner(picture.View(), {22, 20}, 4, 1.5));
  const Picture border([](double x, double y) { return (x > 3) == (y > 20) ? 180.0 : 60.0; });
  EXPECT_FALSE(RefineCorner(border.View(), {3, 20}, 4, 3));
  EXPECT_FALSE(RefineCorner(border.View(), {NAN, 20}, 4, 3));
}

}  // namespace nightmap::refine_corner_test
