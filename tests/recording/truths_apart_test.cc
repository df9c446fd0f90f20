// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/truths_apart.h"

#include <gtest/gtest.h>

namespace nightmap::truths_apart_test {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// Frames at 100.0, 100.1 ... 100.9 s, and true poses as often, of another clock.
RawSequence Recording(std::int64_t late_ns) {
  RawSequence sequence;
  sequence.name = "office.toml:24";
  sequence.ground_truth_file = "office/groundtruth.txt";
  for (int i = 0; i < 10; ++i) {
    const std::int64_t time_ns = 100 * kSecond_ns + i * kSecond_ns / 10;
    sequence.frames.emplace_back().time_ns = time_ns;
    sequence.ground_truth.push_back({time_ns + late_ns, {}});
  }
  return sequence;
}

nlohmann::json ReportOf(const std::vector<RawSequence>& sequences) {
  nlohmann::json report = nlohmann::json::object();
  ReportTruthsApart(sequences, report);
  return report;
}

TEST(ReportTruthsApart, SaysHowFarTheNearestTimesAreApart) {
  for (const auto& [late_s, apart_s] : {std::pair{7200, 7199.1}, {-7200, 7199.1}, {1, 0.1}}) {
    const auto found = ReportOf({Recording(late_s * kSecond_ns)}).at("ground_truths_apart");
    ASSERT_EQ(found.size(), 1U) << late_s;
    EXPECT_EQ(found[0].at("file"), "office/groundtruth.txt");
    EXPECT_NEAR(found[0].at("apart_s"), apart_s, 1e-9);
  }
}

TEST(ReportTruthsApart, NamesOnlyTruthsThatFitNoFrame) {
  RawSequence without = Recording(0), sparse = Recording(0);
  without.ground_truth.clear();
  for (StampedPose& pose : sparse.ground_truth) {  // one a second: none is interpolated
    pose.time_ns = 10 * (pose.time_ns - 100 * kSecond_ns) + 99'650'000'000;
  }
  EXPECT_TRUE(ReportOf({Recording(0), Recording(800'000'000), without, {}}).empty());
  const auto found = ReportOf({Recording(0), sparse, Recording(7200 * kSecond_ns)});
  ASSERT_EQ(found.at("ground_truths_apart").size(), 2U);
  EXPECT_NEAR(found.at("ground_truths_apart")[0].at("apart_s"), 0.05, 1e-9);
}

}  // namespace nightmap::truths_apart_test
