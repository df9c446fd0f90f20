// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/pack_rectangles.h"

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::pack_rectangles_test {

constexpr int kPage_px = 256;

std::vector<Eigen::Vector2i> RandomSizes(std::size_t count) {
  Random random(3, 0);
  std::vector<Eigen::Vector2i> sizes;
  const auto side = [&](double largest) {
    return 1 + static_cast<int>(random.Uniform() * largest);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const double largest = i % 10 == 0 ? kPage_px - 1 : 40;
    sizes.emplace_back(side(largest), side(largest));
  }
  sizes.emplace_back(kPage_px, kPage_px);
  sizes.emplace_back(0, 0);  // a chart without a picture
  return sizes;
}

TEST(PackRectangles, NoneOverlapAndAllAreOnTheirPages) {
  const auto sizes = RandomSizes(500);
  const PackedRectangles packed = PackRectangles(sizes, kPage_px);
  ASSERT_EQ(packed.places.size(), sizes.size());
  std::vector<std::vector<bool>> is_taken(packed.pages.size(),
                                          std::vector<bool>(kPage_px * kPage_px));
  int area = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const auto& [page, corner] = packed.places[i];
    ASSERT_LT(page, packed.pages.size());
    ASSERT_TRUE((corner.array() >= 0).all());
    ASSERT_TRUE(((corner + sizes[i]).array() <= packed.pages[page].array()).all());
    ASSERT_TRUE((packed.pages[page].array() <= kPage_px).all());
    for (int y = corner.y(); y < corner.y() + sizes[i].y(); ++y) {
      for (int x = corner.x(); x < corner.x() + sizes[i].x(); ++x) {
        auto taken = is_taken[page][static_cast<std::size_t>(y * kPage_px + x)];
        ASSERT_FALSE(taken) << "rectangle " << i << " at " << x << ", " << y;
        taken = true;
      }
    }
    area += sizes[i].prod();
  }
  int pages_area = 0;
  for (const Eigen::Vector2i& page : packed.pages) pages_area += page.prod();
  EXPECT_GT(area, 0.6 * pages_area);
}

TEST(PackRectangles, NothingNeedsNoPage) {
  EXPECT_TRUE(PackRectangles({}, kPage_px).pages.empty());
  EXPECT_TRUE(PackRectangles({{0, 0}}, kPage_px).pages.empty());
}

}  // namespace nightmap::pack_rectangles_test
