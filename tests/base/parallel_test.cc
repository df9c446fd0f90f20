// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/parallel.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <set>
#include <thread>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/base/union_find.h"
#include "tests/test_data.h"

namespace nightmap::parallel_test {

TEST(ParallelFor, VisitsEveryItemOnce) {
  for (const int num_threads : {1, 2, 7, 100}) {
    for (const std::size_t num_items : {50, 4097, 100'003}) {
      std::vector<std::atomic<int>> visits(num_items);
      ParallelFor(visits.size(), num_threads, [&](std::size_t i) { ++visits[i]; });
      for (const auto& count : visits) ASSERT_EQ(count, 1);
    }
  }
  ParallelFor(0, 4, [](std::size_t) { ADD_FAILURE() << "there is no item"; });
}

TEST(ParallelForShort, VisitsEveryItemOnce) {
  for (const std::size_t count : {0, 1, 2048, 5000}) {
    std::vector<int> visits(count);
    ParallelForShort(count, 3, [&](std::size_t i) { ++visits[i]; });
    EXPECT_EQ(visits, std::vector<int>(count, 1));
  }
}

TEST(ParallelFor, CarriesTheExceptionOfTheLowestItem) {
  for (const int num_threads : {1, 4}) {
    try {
      ParallelFor(20, num_threads, [](std::size_t i) {
        if (i >= 5) throw DataError("item {}", i);
      });
      ADD_FAILURE() << "threw nothing";
    } catch (const DataError& error) {
      EXPECT_STREQ(error.what(), "item 5");
    }
  }
}

TEST(ParallelFor, CarriesTheExceptionOfTheLowestOfManyItems) {
  for (int trial = 0; trial < 20; ++trial) {
    const auto fail = [](std::size_t i) {
      if (i % 1000 == 999) throw DataError("item {}", i);
    };
    NIGHTMAP_EXPECT_ERROR(DataError, ParallelFor(100'000, 4, fail), "item 999");
  }
}

// Item 0 fails after item 1 and is still the one reported.
TEST(ParallelFor, TheLowestItemIsToldEvenIfItFailsLast) {
  std::atomic<bool> has_failed = false;
  const auto fail = [&](std::size_t i) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (i == 0 && !has_failed && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(i == 0 ? 50 : 0));
    has_failed = true;
    throw DataError("item {}", i);
  };
  NIGHTMAP_EXPECT_ERROR(DataError, ParallelFor(2, 2, fail), "item 0");
}

TEST(ParallelFor, StartsNoItemAfterAFailure) {
  std::vector<std::size_t> started;
  const auto fail_at_five = [&](std::size_t i) {
    started.push_back(i);
    if (i == 5) throw DataError("item {}", i);
  };
  NIGHTMAP_EXPECT_ERROR(DataError, ParallelFor(20, 1, fail_at_five), "item 5");
  EXPECT_EQ(started, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
}

// Without room for their stacks the system makes no threads. The work is done all the same.
TEST(ParallelForDeathTest, DoesTheWorkWithTheThreadsItGets) {
  // The limit that provokes the case ends a program under AddressSanitizer, which must map its own
  // memory; the plain build of the same suite runs this test.
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer ends the program when it gets no memory";
#endif
  const auto visit_all = [] {
    rlimit no_more{};
    getrlimit(RLIMIT_AS, &no_more);
    no_more.rlim_cur = 1;
    setrlimit(RLIMIT_AS, &no_more);
    std::atomic<int> num_visits = 0;
    ParallelFor(100, 4, [&](std::size_t) { ++num_visits; });
    std::_Exit(num_visits == 100 ? 0 : 1);
  };
  EXPECT_EXIT(visit_all(), testing::ExitedWithCode(0), "");
}

TEST(ParallelFor, ResultsAreEqualAtAnyNumberOfThreads) {
  const auto run = [](int num_threads) {
    std::vector<double> results(500);
    ParallelFor(results.size(), num_threads, [&](std::size_t i) {
      Random random(1, i);
      for (std::size_t k = 0; k <= i % 50; ++k) results[i] += random.Gaussian();
    });
    return results;
  };
  EXPECT_EQ(run(1), run(4));
}

// Worked out apart from this code: maps of two machines agree only if their numbers do.
TEST(Random, IsTheSequenceSplitMix64Defines) {
  Random random(1, 2, 3);
  EXPECT_EQ(random.Next(), 0xa2319b1eec583446U);
  EXPECT_EQ(random.Next(), 0x3da3fe772548faceU);
  EXPECT_EQ(random.Next(), 0x984238e014cbe149U);
}

TEST(Random, EqualSeedsGiveEqualStreamsAndOthersDiffer) {
  Random a(1, 2, 3), b(1, 2, 3);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(a.Next(), b.Next());
  std::set<std::uint64_t> firsts;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (std::uint64_t stream = 0; stream < 10; ++stream) {
      for (std::uint64_t substream = 0; substream < 10; ++substream) {
        firsts.insert(Random(seed, stream, substream).Next());
      }
    }
  }
  EXPECT_EQ(firsts.size(), 1000U);
}

TEST(Random, HasTheMomentsItSays) {
  Random random(4);
  constexpr int kCount = 20000;
  double sum = 0, gaussian_sum = 0, gaussian_squares = 0;
  std::vector<int> histogram(7, 0);
  for (int i = 0; i < kCount; ++i) {
    const double uniform = random.Uniform(-1, 3);
    EXPECT_TRUE(uniform >= -1 && uniform < 3);
    sum += uniform;
    const double gaussian = random.Gaussian();
    gaussian_sum += gaussian;
    gaussian_squares += gaussian * gaussian;
    ++histogram.at(random.Index(histogram.size()));
  }
  EXPECT_NEAR(sum / kCount, 1, 0.05);
  EXPECT_NEAR(gaussian_sum / kCount, 0, 0.05);
  EXPECT_NEAR(gaussian_squares / kCount, 1, 0.05);
  for (const int count : histogram) EXPECT_NEAR(count, kCount / 7.0, 300);
  EXPECT_EQ(random.Index(1), 0U);
}

// Against the plain definition: labels that are rewritten by every join.
TEST(UnionFind, AgreesWithRelabeling) {
  constexpr std::size_t kSize = 60;
  Random random(8);
  UnionFind sets(kSize);
  std::vector<std::size_t> labels(kSize);
  for (std::size_t i = 0; i < kSize; ++i) labels[i] = i;
  for (int step = 0; step < 45; ++step) {
    const std::size_t a = random.Index(kSize), b = random.Index(kSize);
    sets.Join(a, b);
    const std::size_t from = std::max(labels[a], labels[b]), to = std::min(labels[a], labels[b]);
    for (std::size_t& label : labels) label = label == from ? to : label;
    for (std::size_t i = 0; i < kSize; ++i) ASSERT_EQ(sets.Find(i), labels[i]);
  }
}

}  // namespace nightmap::parallel_test
