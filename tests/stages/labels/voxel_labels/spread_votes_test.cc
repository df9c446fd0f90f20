// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/voxel_labels/spread_votes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "pipeline/base/random.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap::spread_votes_test {

using Votes = std::vector<float>;

// A floor of kEdge x kEdge voxels, whose votes `votes_of` gives.
constexpr int kEdge = 16;

template <typename VotesOf>
VoteTable Floor(const VotesOf& votes_of) {
  std::map<std::uint64_t, Votes> voxels;
  for (int x = 0; x < kEdge; ++x) {
    for (int y = 0; y < kEdge; ++y) voxels[MortonCode({x, y, 0})] = votes_of(x, y);
  }
  VoteTable table;
  for (const auto& [code, votes] : voxels) {
    table.codes.push_back(code);
    table.num_classes = votes.size();
    table.weights.insert(table.weights.end(), votes.begin(), votes.end());
  }
  return table;
}

Votes VotesAt(const VoteTable& table, int x, int y) {
  const auto found = std::ranges::lower_bound(table.codes, MortonCode({x, y, 0}));
  const auto begin = table.weights.begin() +
                     (found - table.codes.begin()) * static_cast<std::ptrdiff_t>(table.num_classes);
  return {begin, begin + static_cast<std::ptrdiff_t>(table.num_classes)};
}

std::ptrdiff_t LabelAt(const VoteTable& table, int x, int y) {
  const Votes votes = VotesAt(table, x, y);
  return std::ranges::max_element(votes) - votes.begin();
}

VoteTable RandomFloor() {
  Random random(1);
  return Floor([&](int, int) {
    Votes votes(4);
    for (float& vote : votes) vote = static_cast<float>(random.Uniform());
    return votes;
  });
}

TEST(SpreadVotes, KeepsTheSumOfEachVoxel) {
  VoteTable table = RandomFloor();
  const Votes before = table.weights;
  SpreadVotes({}, 2, &table);
  EXPECT_NE(table.weights, before);
  for (std::size_t i = 0; i < table.codes.size(); ++i) {
    const auto sum = [&](const Votes& votes) {
      return std::accumulate(&votes[4 * i], &votes[4 * i] + 4, 0.0F);
    };
    ASSERT_NEAR(sum(table.weights), sum(before), 1e-4);
  }
}

TEST(SpreadVotes, IsTheSameAtAnyNumberOfThreads) {
  VoteTable one = RandomFloor();
  VoteTable four = one;
  SpreadVotes({}, 1, &one);
  SpreadVotes({}, 4, &four);
  EXPECT_EQ(one.weights, four.weights);
}

TEST(SpreadVotes, WithoutWeightOrIterationsNothingChanges) {
  const VoteTable table = RandomFloor();
  for (const SpreadOptions& options : {SpreadOptions{0, 20}, SpreadOptions{16, 0}}) {
    VoteTable spread = table;
    SpreadVotes(options, 2, &spread);
    EXPECT_EQ(spread.weights, table.weights);
  }
}

// A table of class 1 on a floor of class 0. Its left part was in few pictures, most of which took
// it for class 2: the rest of the table corrects them.
TEST(SpreadVotes, APartThatFewPicturesMistookFollowsTheThing) {
  VoteTable table = Floor([](int x, int) -> Votes {
    if (x >= 12) return {8, 0, 0};
    return x < 3 ? Votes{0, 1.4F, 1.6F} : Votes{0, 8, 2};
  });
  ASSERT_EQ(LabelAt(table, 1, 5), 2);
  SpreadVotes({}, 2, &table);
  for (int y = 0; y < kEdge; ++y) {
    for (int x = 0; x < kEdge; ++x) ASSERT_EQ(LabelAt(table, x, y), x < 12 ? 1 : 0) << x << y;
  }
}

// Two things side by side, each of which some pictures took for the other class: the border stays.
TEST(SpreadVotes, ABorderOfThingsStays) {
  VoteTable table = Floor([](int x, int) { return x < 8 ? Votes{0, 7, 3} : Votes{0, 3, 7}; });
  SpreadVotes({}, 2, &table);
  for (int y = 0; y < kEdge; ++y) {
    for (int x = 0; x < kEdge; ++x) ASSERT_EQ(LabelAt(table, x, y), x < 8 ? 1 : 2) << x << y;
  }
}

TEST(SpreadVotes, AVoxelThatNobodySawIsLikeItsNeighboursAndSaysLittle) {
  VoteTable table = Floor([](int x, int y) {
    return x == 4 && y == 4 ? Votes{0, 0} : x < 8 ? Votes{0, 5} : Votes{5, 0};
  });
  SpreadVotes({}, 2, &table);
  EXPECT_EQ(LabelAt(table, 4, 4), 1);
  EXPECT_LT(VotesAt(table, 4, 4)[1], 0.2F);
}

TEST(SpreadVotes, WhereNobodySawAnythingNothingIsSaid) {
  VoteTable table = Floor([](int, int) { return Votes{0, 0}; });
  SpreadVotes({}, 2, &table);
  EXPECT_THAT(table.weights, testing::Each(0.0F));
}

}  // namespace nightmap::spread_votes_test
