// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/ancestors.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/random.h"

namespace nightmap::ancestors_test {

using Nodes = std::vector<std::size_t>;

Nodes WayToRoot(const Nodes& parents, std::size_t node) {
  Nodes way = {node};
  while (parents[way.back()] != way.back()) way.push_back(parents[way.back()]);
  return way;
}

std::size_t NaiveCommon(const Nodes& parents, std::size_t a, std::size_t b) {
  const Nodes of_a = WayToRoot(parents, a);
  const Nodes of_b = WayToRoot(parents, b);
  return *std::ranges::find_if(
      of_a, [&](std::size_t node) { return std::ranges::count(of_b, node) > 0; });
}

// Each node hangs on one of the `spread` before it: 1 makes a chain, many a bush.
Nodes DrawTree(std::size_t num_nodes, std::size_t spread, Random& random) {
  Nodes parents = {0};
  for (std::size_t i = 1; i < num_nodes; ++i) {
    parents.push_back(i - 1 - random.Index(std::min(i, spread)));
  }
  return parents;
}

TEST(Ancestors, AreThoseOfANaiveClimb) {
  Random random(1);
  for (const std::size_t spread : {1U, 2U, 5U, 300U}) {
    const Nodes parents = DrawTree(300, spread, random);
    Ancestors ancestors(parents.size());
    for (std::size_t i = 1; i < parents.size(); ++i) ancestors.Hang(i, parents[i]);
    for (int trial = 0; trial < 3000; ++trial) {
      const std::size_t a = random.Index(300), b = random.Index(300);
      ASSERT_EQ(ancestors.Common(a, b), NaiveCommon(parents, a, b)) << a << " " << b;
      ASSERT_EQ(ancestors.Root(a), 0U);
    }
  }
}

TEST(Ancestors, FollowATreeThatIsHungElsewhere) {
  Ancestors ancestors(7);
  for (const std::size_t i : {1U, 2U}) ancestors.Hang(i, i - 1);
  for (const std::size_t i : {4U, 5U, 6U}) ancestors.Hang(i, i - 1);
  EXPECT_EQ(ancestors.Root(2), 0U);
  EXPECT_EQ(ancestors.Root(6), 3U);
  for (const auto& [node, parent] : {std::pair(4U, 1U), {3U, 4U}, {5U, 4U}, {6U, 5U}}) {
    ancestors.Hang(node, parent);
  }
  EXPECT_EQ(ancestors.Root(3), 0U);
  EXPECT_EQ(ancestors.Common(3, 6), 4U);
  EXPECT_EQ(ancestors.Common(2, 6), 1U);
}

}  // namespace nightmap::ancestors_test
