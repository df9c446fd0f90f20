// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/libraries/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>
#include <opencv2/core.hpp>

namespace nightmap {
namespace {

constexpr int kNumRepeats = 9;

double Time_ms(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

double TimeOf_ms(const std::function<void(int)>& run, int num_threads) {
  const clockid_t clock = num_threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC;
  const double start_ms = Time_ms(clock);
  run(num_threads);
  return Time_ms(clock) - start_ms;
}

struct BestTimes {
  double ours_ms = std::numeric_limits<double>::max();
  double other_ms = std::numeric_limits<double>::max();

  double Ratio() const { return other_ms / ours_ms; }
};

BestTimes Measure(const Comparison& comparison, int num_threads) {
  cv::setNumThreads(num_threads);
  comparison.run_ours(num_threads);
  comparison.run_other(num_threads);
  BestTimes best;
  for (int i = 0; i < kNumRepeats; ++i) {
    best.ours_ms = std::min(best.ours_ms, TimeOf_ms(comparison.run_ours, num_threads));
    best.other_ms = std::min(best.other_ms, TimeOf_ms(comparison.run_other, num_threads));
  }
  return {best.ours_ms / comparison.num_items, best.other_ms / comparison.num_items};
}

}  // namespace

void PrintHeader() {
  fmt::print(
      "| ours | instead of X | input | ours (ms) | X (ms) | X / ours | X / ours, 2 threads | "
      "difference of the results |\n"
      "| --- | --- | --- | ---: | ---: | ---: | ---: | --- |\n");
}

void PrintComparison(const Comparison& comparison) {
  const BestTimes one = Measure(comparison, 1);
  const BestTimes two = Measure(comparison, 2);
  fmt::print("| {} | {} | {} | {:.3g} | {:.3g} | {:.2f} | {:.2f} | {} |\n",
             comparison.ours,
             comparison.other,
             comparison.input,
             one.ours_ms,
             one.other_ms,
             one.Ratio(),
             two.Ratio(),
             comparison.difference());
  std::fflush(stdout);
}

}  // namespace nightmap
