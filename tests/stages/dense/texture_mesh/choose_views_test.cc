// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/choose_views.h"

#include "tests/test_data.h"

namespace nightmap::choose_views_test {

// A strip of triangles, each with the next one as neighbour.
std::vector<Triangle> Strip(std::uint32_t count) {
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < count; ++i) triangles.push_back({i, i + 1, i + 2});
  return triangles;
}

BestViews Views(const std::vector<TriangleView>& views) {
  BestViews best;
  std::ranges::copy(views, best.begin());
  return best;
}

TEST(ChooseViews, NeighborsShareAnEdge) {
  const auto neighbors = NeighborsOf(Strip(3));
  EXPECT_THAT(neighbors[0], testing::UnorderedElementsAre(0, 0, 1));
  EXPECT_THAT(neighbors[1], testing::UnorderedElementsAre(0, 1, 2));
}

TEST(ChooseViews, OneViewThatIsGoodForAllGoesBeforeTheBestOfEach) {
  const std::vector<BestViews> found = {
      Views({{0, 1.0F}, {2, 0.6F}}), Views({{1, 1.0F}, {2, 0.6F}}), Views({{2, 1.0F}, {1, 0.6F}})};
  EXPECT_THAT(ChooseViews(found, NeighborsOf(Strip(3))), testing::Each(2));
}

TEST(ChooseViews, AMuchWorseViewIsNotTaken) {
  const std::vector<BestViews> found = {
      Views({{0, 1.0F}}), Views({{1, 1.0F}, {0, 0.4F}}), Views({{0, 1.0F}})};
  EXPECT_THAT(ChooseViews(found, NeighborsOf(Strip(3))), testing::ElementsAre(0, 1, 0));
}

TEST(ChooseViews, ATriangleBetweenTwoOfOneViewTakesIt) {
  // Most triangles have view 0 as a good one; those around the third have not.
  std::vector<BestViews> found(3, Views({{0, 1.0F}}));
  found.insert(found.end(),
               {Views({{1, 1.0F}}), Views({{0, 1.0F}, {1, 0.9F}}), Views({{1, 1.0F}})});
  EXPECT_THAT(ChooseViews(found, NeighborsOf(Strip(6))), testing::ElementsAre(0, 0, 0, 1, 1, 1));
}

TEST(ChooseViews, TrianglesThatNobodySeesHaveNoView) {
  const std::vector<BestViews> found = {Views({}), Views({{3, 0.1F}}), Views({})};
  const auto neighbors = NeighborsOf(Strip(3));
  const auto views = ChooseViews(found, neighbors);
  EXPECT_THAT(views, testing::ElementsAre(kNoView, 3, kNoView));
  const auto charts = ChartsOf(views, neighbors);
  ASSERT_EQ(charts.size(), 3U);
  EXPECT_EQ(charts[1].view, 3U);
  EXPECT_THAT(charts[2].triangles, testing::ElementsAre(2));
}

TEST(ChooseViews, ChartsHangTogether) {
  const auto charts = ChartsOf({0, 0, 1, 0}, NeighborsOf(Strip(4)));
  ASSERT_EQ(charts.size(), 3U);
  EXPECT_THAT(charts[0].triangles, testing::ElementsAre(0, 1));
  EXPECT_THAT(charts[2].triangles, testing::ElementsAre(3));
}

}  // namespace nightmap::choose_views_test
