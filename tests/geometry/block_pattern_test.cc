// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/block_pattern.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::block_pattern_test {

constexpr int kNumPoses = 60;
constexpr int kNumRight = 3;

bool IsFree(int pose) { return pose % 7 != 0; }

std::set<std::pair<int, int>> RandomPairs() {
  Random random(3);
  std::set<std::pair<int, int>> pairs;
  while (pairs.size() < 150) {
    const int a = static_cast<int>(random.Index(kNumPoses));
    const int b = static_cast<int>(random.Index(kNumPoses));
    if (a < b && IsFree(a) && IsFree(b)) pairs.emplace(a, b);
  }
  return pairs;
}

BlockPattern MakePattern(const std::set<std::pair<int, int>>& pairs) {
  std::vector<bool> is_free;
  for (int pose = 0; pose < kNumPoses; ++pose) is_free.push_back(IsFree(pose));
  std::vector<std::vector<int>> neighbours(kNumPoses);
  for (const auto& [a, b] : pairs) {
    neighbours[static_cast<std::size_t>(a)].push_back(b);
    neighbours[static_cast<std::size_t>(b)].push_back(a);
  }
  return MakeBlockPattern(is_free, neighbours, 6, kNumRight);
}

TEST(BlockPattern, FreePosesHaveARankEach) {
  std::set<int> ranks;
  const BlockPattern pattern = MakePattern(RandomPairs());
  for (int pose = 0; pose < kNumPoses; ++pose) {
    const int rank = pattern.rank[static_cast<std::size_t>(pose)];
    if (IsFree(pose)) {
      EXPECT_TRUE(ranks.insert(rank).second);
    } else {
      EXPECT_EQ(rank, -1);
    }
  }
  EXPECT_EQ(*ranks.begin(), 0);
  EXPECT_EQ(*ranks.rbegin() + 1, static_cast<int>(ranks.size()));
}

TEST(BlockPattern, EachPairIsOnceInTheLowerTriangle) {
  const auto pairs = RandomPairs();
  const BlockPattern pattern = MakePattern(pairs);
  std::set<std::pair<int, int>> found;
  for (int pose = 0; pose < kNumPoses; ++pose) {
    int before = pattern.rank[static_cast<std::size_t>(pose)];
    for (const int later : pattern.later[static_cast<std::size_t>(pose)]) {
      EXPECT_GT(pattern.rank[static_cast<std::size_t>(later)], before);
      before = pattern.rank[static_cast<std::size_t>(later)];
      EXPECT_TRUE(found.insert(std::minmax(pose, later)).second);
    }
  }
  EXPECT_EQ(found, pairs);
}

TEST(BlockPattern, RowsOfAColumnAreItsBlocksInOrder) {
  const BlockPattern pattern = MakePattern(RandomPairs());
  const auto num_free =
      static_cast<int>(std::ranges::count_if(pattern.rank, [](int rank) { return rank >= 0; }));
  ASSERT_EQ(pattern.lower.rows(), 6 * num_free + kNumRight);
  for (int pose = 0; pose < kNumPoses; ++pose) {
    if (!IsFree(pose)) continue;
    std::vector<int> blocks = {pose};
    const auto& later = pattern.later[static_cast<std::size_t>(pose)];
    blocks.insert(blocks.end(), later.begin(), later.end());
    std::vector<int> rows;
    for (const int block : blocks) {
      for (int i = 0; i < 6; ++i) {
        rows.push_back(6 * pattern.rank[static_cast<std::size_t>(block)] + i);
      }
    }
    for (int i = 0; i < kNumRight; ++i) rows.push_back(6 * num_free + i);
    const int* const columns =
        pattern.lower.outerIndexPtr() + 6 * pattern.rank[static_cast<std::size_t>(pose)];
    for (int i = 0; i < 6; ++i) {
      EXPECT_TRUE(
          std::ranges::equal(rows,
                             std::vector<int>(pattern.lower.innerIndexPtr() + columns[i],
                                              pattern.lower.innerIndexPtr() + columns[i + 1])));
    }
  }
}

TEST(BlockPattern, AChainFillsNothing) {
  std::set<std::pair<int, int>> chain;
  for (int pose = 0; pose + 1 < 6; ++pose) chain.emplace(pose + 1, pose + 2);
  const BlockPattern pattern = MakePattern({chain.begin(), std::prev(chain.end())});
  for (const auto& later : pattern.later) EXPECT_LE(later.size(), 1U);
}

}  // namespace nightmap::block_pattern_test
