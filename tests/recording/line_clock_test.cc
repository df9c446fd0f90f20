// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/line_clock.h"

#include <gtest/gtest.h>

#include <map>

#include "pipeline/base/random.h"

namespace nightmap::line_clock_test {

constexpr std::int64_t kMs = 1'000'000;

// Times in ms of lines of one kind; -1: none.
std::vector<std::int64_t> TimesOf(const std::vector<std::int64_t>& stated_ms) {
  std::vector<StampedLine> lines;
  for (std::size_t i = 0; i < stated_ms.size(); ++i) {
    lines.push_back({static_cast<int>(i), 0, stated_ms[i] * kMs});
  }
  const LineClock clock(lines);
  std::vector<std::int64_t> times_ms;
  for (const StampedLine& line : lines) {
    times_ms.push_back(clock.TimeOf_ns(line.line).value_or(-kMs) / kMs);
  }
  return times_ms;
}

using Times = std::vector<std::int64_t>;

TEST(LineClockTest, ALineThatIsStampedEarlyIsBetweenItsNeighbours) {
  EXPECT_EQ(TimesOf({100, 200, 300, 250, 500, 600}), (Times{100, 200, 300, 400, 500, 600}));
  EXPECT_EQ(TimesOf({100, 200, 300, 50, 500, 600}), (Times{100, 200, 300, 400, 500, 600}));
  EXPECT_EQ(TimesOf({100, 200, 300, 400, 350}), (Times{100, 200, 300, 400, 462}));
}

TEST(LineClockTest, ALineThatIsStampedLateIsBetweenItsNeighbours) {
  EXPECT_EQ(TimesOf({100, 200, 550, 400, 500, 600}), (Times{100, 200, 300, 400, 500, 600}));
  EXPECT_EQ(TimesOf({900, 200, 300, 400, 500, 600}).back(), 600);
}

TEST(LineClockTest, ALineIsNoFartherFromTheLineBeforeThanUsual) {
  Times stated;
  for (int i = 1; i <= 100; ++i) stated.push_back(100 * i);
  stated.push_back(9950);
  for (int i = 0; i < 100; ++i) stated.push_back(60'000 + 100 * i);
  EXPECT_EQ(TimesOf(stated)[100], 10'100);
}

// Damaged stamps may lie before 0.
TEST(LineClockTest, TimesBeforeZeroAreInOrderLikeOthers) {
  EXPECT_EQ(TimesOf({-5000, -4900, -4800}).size(), 3U);
  EXPECT_EQ(TimesOf({-5000, 100, 200}).back(), 200);
  EXPECT_EQ(TimesOf({-9000}).size(), 1U);
}

TEST(LineClockTest, WhatIsNoTimeHasNone) {
  EXPECT_EQ(TimesOf({1000, 2000, 2000, 0, 3000}), (Times{1000, 2000, -1, -1, 3000}));
  EXPECT_EQ(TimesOf({1000, 9000, 6000, 9500}), (Times{1000, 9000, -1, 9500}));
  EXPECT_EQ(TimesOf({0, 100}), (Times{0, 100}));
  EXPECT_FALSE(LineClock({}).TimeOf_ns(0));
  EXPECT_FALSE(LineClock({{7, 0, 1}}).TimeOf_ns(6));
}

// Odometry is stamped 40 ms before the scan whose line is written before it.
std::vector<StampedLine> TwoKinds(int count) {
  std::vector<StampedLine> lines;
  for (int i = 0; i < count; ++i) {
    lines.push_back({2 * i, 0, (1000 + 100 * i) * kMs});
    lines.push_back({2 * i + 1, 1, (960 + 100 * i) * kMs});
  }
  return lines;
}

TEST(LineClockTest, KindsInOrderStayAsTheyAre) {
  const auto lines = TwoKinds(50);
  const LineClock clock(lines);
  for (const StampedLine& line : lines) EXPECT_EQ(clock.TimeOf_ns(line.line), line.stated_ns);
}

TEST(LineClockTest, OtherLinesStayWhereOneKindGoesBack) {
  auto lines = TwoKinds(50);
  lines[40].stated_ns -= 300 * kMs;
  const LineClock clock(lines);
  for (const StampedLine& line : lines) {
    const auto time_ns = *clock.TimeOf_ns(line.line);
    if (line.line < 32 || line.line > 44) {
      EXPECT_EQ(time_ns, line.stated_ns) << line.line;
    }
  }
  EXPECT_NEAR(static_cast<double>(*clock.TimeOf_ns(40)), 3000. * kMs, 100. * kMs);
}

// Batches of lines of two kinds, some stamped early: the order of all lines is kept.
TEST(LineClockTest, BatchesOfAllKindsStayTogether) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed, 0);
    std::vector<StampedLine> lines;
    std::int64_t stamp_ns = 0;
    for (int i = 0; i < 300; ++i) {
      if (i % 8 == 0) {
        stamp_ns = (1'000 + 500 * (i / 8)) * kMs;
        if (random.Uniform() < 0.3) stamp_ns -= static_cast<std::int64_t>(900e6 * random.Uniform());
      }
      lines.push_back({i, i % 3 == 0 ? 1 : 0, stamp_ns += kMs / 2});
    }
    const LineClock clock(lines);
    std::size_t num_moved = 0;
    for (int i = 0; i < 300; ++i) {
      const auto time_ns = clock.TimeOf_ns(i);
      ASSERT_TRUE(time_ns);
      if (i > 0) {
        // Kinds may overlap by no more than a batch is long.
        EXPECT_GT(*time_ns, *clock.TimeOf_ns(i - 1) - 4 * kMs) << seed << ' ' << i;
      }
      num_moved += *time_ns == lines[static_cast<std::size_t>(i)].stated_ns ? 0 : 1;
      EXPECT_LT(std::abs(*time_ns - (1'000 + 500 * (i / 8)) * kMs), 1500 * kMs);
    }
    EXPECT_LT(num_moved, 150u);
  }
}

// Whatever the stamps, times of a kind ascend, and as many lines as before have one.
TEST(LineClockTest, TimesOfAKindAscend) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed, 1);
    std::vector<StampedLine> lines;
    const double jump_s = seed % 3 == 0 ? 4 : 0.4;
    for (int i = 0; i < 60; ++i) {
      const int kind = random.Uniform() < 0.3 ? 1 : 0;
      const double time_s = std::max(0.0, 0.05 * i + jump_s * (random.Uniform() - 0.5)) +
                            (seed % 5 == 0 ? 1000 * kind : 0);
      lines.push_back({i, kind, static_cast<std::int64_t>(1e3 * time_s) * (seed % 2 ? kMs : 1)});
    }
    const LineClock clock(lines);
    std::map<int, std::int64_t> last_ns;
    for (const StampedLine& line : lines) {
      const auto time_ns = clock.TimeOf_ns(line.line);
      if (!time_ns) continue;
      EXPECT_GE(*time_ns, 0);
      const auto [before, is_first] = last_ns.emplace(line.kind, *time_ns);
      if (!is_first) {
        EXPECT_GT(*time_ns, before->second) << seed << ' ' << line.line;
      }
      before->second = *time_ns;
    }
  }
}

TEST(LineClockTest, KindsOfOtherClocksArePutRightAlone) {
  auto lines = TwoKinds(50);
  for (StampedLine& line : lines) line.stated_ns += line.kind == 1 ? 3600'000 * kMs : 0;
  const auto stated = lines;
  lines[40].stated_ns -= 150 * kMs;
  const LineClock clock(lines);
  for (const StampedLine& line : stated) EXPECT_EQ(clock.TimeOf_ns(line.line), line.stated_ns);
}

}  // namespace nightmap::line_clock_test
