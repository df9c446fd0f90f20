// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/inverted_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/base/random.h"

namespace nightmap::inverted_file_test {

TEST(InvertedFileTest, RanksTheSameFrameFirst) {
  Random random(5);
  std::vector<std::vector<int>> words(40);
  for (auto& frame : words) {
    for (int i = 0; i < 200; ++i) frame.push_back(static_cast<int>(random.Index(2000)));
  }
  const InvertedFile file(words);
  for (int frame = 0; frame < 40; ++frame) {
    const auto results = file.Query(words[static_cast<std::size_t>(frame)], 3);
    ASSERT_EQ(results.size(), 3U);
    EXPECT_EQ(results[0].frame_idx, frame);
    EXPECT_NEAR(results[0].score, 1.0, 1e-5);
    EXPECT_LT(results[1].score, 0.6);
  }
}

TEST(InvertedFileTest, WeighsRareWordsMore) {
  // Word 0 is in every frame, word 1 only in frame 2.
  const InvertedFile file({{0, 3}, {0, 4}, {1, 5}, {0, 6}, {0, 7}});
  EXPECT_EQ(file.Query({0, 1}, 1).at(0).frame_idx, 2);
}

// The scores as the definition has them, one pair of frames after the other.
TEST(InvertedFileTest, ScoresAreCosinesOfWeightedCounts) {
  Random random(6);
  std::vector<std::vector<int>> words(12);
  for (auto& frame : words) {
    for (int i = 0; i < 50; ++i) frame.push_back(static_cast<int>(random.Index(40)));
  }
  const auto weights = [&](const std::vector<int>& frame) {
    std::map<int, double> weight;
    for (const int word : frame) ++weight[word];
    double squared_norm = 0;
    for (auto& [word, value] : weight) {
      const auto num_frames = std::ranges::count_if(words, [&, word = word](const auto& other) {
        return std::ranges::find(other, word) != other.end();
      });
      value *= std::log(13.0 / static_cast<double>(num_frames));
      squared_norm += value * value;
    }
    for (auto& [word, value] : weight) value /= std::sqrt(squared_norm);
    return weight;
  };
  const InvertedFile file(words);
  for (const auto& result : file.Query(words[7], 12)) {
    const auto a = weights(words[7]);
    const auto b = weights(words[static_cast<std::size_t>(result.frame_idx)]);
    double cosine = 0;
    for (const auto& [word, value] : a) cosine += b.contains(word) ? value * b.at(word) : 0;
    EXPECT_NEAR(result.score, cosine, 1e-5) << result.frame_idx;
  }
}

TEST(InvertedFileTest, BreaksTiesByFrameAndHonoursLimits) {
  const InvertedFile file({{1, 2}, {1, 2}, {1, 2}, {}});
  const auto all = file.Query({1, 2}, 10);
  ASSERT_EQ(all.size(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(all[static_cast<std::size_t>(i)].frame_idx, i);
  EXPECT_EQ(file.Query({1, 2}, 10, 1).size(), 1U);
  EXPECT_TRUE(file.Query({1, 2}, 10, 0).empty());
  EXPECT_TRUE(file.Query({9, 77}, 10).empty());
  EXPECT_TRUE(file.Query({}, 10).empty());
  EXPECT_TRUE(InvertedFile().Query({1}, 10).empty());
}

// Word k is in the frames from k on, so that higher words are rarer.
TEST(InvertedFileTest, TheRarestWordsFillTheirLimits) {
  std::vector<std::vector<int>> words(20);
  for (int frame = 0; frame < 20; ++frame) {
    for (int word = 0; word <= frame; ++word)
      words[static_cast<std::size_t>(frame)].push_back(word);
  }
  const InvertedFile file(words);
  const std::vector<int> query = {3, 19, 17, 16, 18, 3, 99};
  const auto expect_as_of =
      [&](const std::vector<int>& kept, std::size_t min_words, std::size_t max) {
        const auto expected = file.Query(kept, 20);
        const auto results = file.QueryRarest(query, 20, min_words, max);
        ASSERT_EQ(results.size(), expected.size()) << min_words << " " << max;
        for (std::size_t i = 0; i < results.size(); ++i) {
          EXPECT_EQ(results[i].frame_idx, expected[i].frame_idx);
          EXPECT_EQ(results[i].score, expected[i].score);
        }
      };
  expect_as_of(query, 0, 1000);
  expect_as_of({19, 17, 16, 18}, 0, 26);  // 1 + 2 + 3 + 4 postings, and 17 of word 3
  expect_as_of({19, 17, 18}, 0, 9);
  expect_as_of({19, 17, 18}, 3, 0);
  expect_as_of(query, 5, 0);
  expect_as_of({}, 0, 0);
}

}  // namespace nightmap::inverted_file_test
