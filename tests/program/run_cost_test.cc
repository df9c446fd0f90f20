// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/run_cost.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace nightmap::run_cost_test {

TEST(RunCost, CountsWorkAndMemory) {
  const RunCost cost;
  const nlohmann::json before = cost.ForReceipt();
  constexpr std::size_t kNumBytes = 100'000'000;
  std::vector<unsigned char> bytes(kNumBytes);
  unsigned sum = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) sum += bytes[i] = static_cast<unsigned char>(i);
  EXPECT_NE(sum, 0U);
  const nlohmann::json after = cost.ForReceipt();
  EXPECT_GT(after["cpu_time_s"], before["cpu_time_s"]);
  EXPECT_GE(after["peak_memory_bytes"], kNumBytes);
  EXPECT_GT(after["wall_time_s"], before["wall_time_s"]);
  EXPECT_EQ(after["start_time"], before["start_time"]);
  EXPECT_THAT(after["start_time"].get<std::string>(),
              testing::MatchesRegex("[0-9]+-[0-9]+-[0-9]+T[0-9]+:[0-9]+:[0-9]+Z"));
}

}  // namespace nightmap::run_cost_test
