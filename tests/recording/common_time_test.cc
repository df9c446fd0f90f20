// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/common_time.h"

#include "tests/test_data.h"

namespace nightmap::common_time_test {

constexpr std::int64_t kS = 1'000'000'000;

class CommonTimeTest : public testing::Test {
 protected:
  CommonTimeTest() {
    for (const auto& [id, kind] :
         {std::pair{"laser", SignalKind::kScan}, std::pair{"wheels", SignalKind::kOdometry}}) {
      site_.sensors.emplace_back().id = id;
      site_.sensors.back().kind = kind;
      site_.signals.emplace_back();
      site_.signals.back().sensor_idx = static_cast<int>(site_.signals.size()) - 1;
      site_.signals.back().source = "lab.toml:" + std::to_string(site_.signals.size());
      signals_.push_back({kind, id, {}, {}});
    }
  }

  // One sample per second, from and to.
  void Record(std::size_t sensor, std::int64_t from_s, std::int64_t to_s) {
    signals_[sensor].samples.clear();
    for (std::int64_t s = from_s; s <= to_s; ++s)
      signals_[sensor].samples.push_back({s * kS, {}, {}});
  }
  std::vector<std::string> Said() { return DemandCommonTime(site_, signals_); }

  SiteConfig site_;
  std::vector<Signal> signals_;
};

TEST_F(CommonTimeTest, OdometryOfAnotherClockIsRefusedWithItsOffset) {
  Record(0, 1'700'000'000, 1'700'000'100);
  Record(1, 5, 105);
  site_.signals[1].time_offset_s = 2.5;
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Said(),
                        "lab.toml:2: odometry and scans have no moment in common: \"wheels\" from "
                        "5.000000 s to 105.000000 s, \"laser\" from 1700000000.000000 s to "
                        "1700000100.000000 s: they have different clocks; where both started "
                        "together, write time_offset_s = 1699999997.500000 in the [[signal]]");
  Record(1, 1'700'000'100, 1'700'000'200);
  EXPECT_EQ(Said().size(), 1u);
  site_.robot_truth.odometry = "wheels";
  Record(1, 5, 105);
  EXPECT_TRUE(Said().empty());
  site_.robot_truth.odometry.clear();
  site_.sequences.emplace_back();
  EXPECT_TRUE(Said().empty());
}

TEST_F(CommonTimeTest, OdometryOfFewerThanHalfOfTheScansIsSaid) {
  Record(0, 100, 199);
  Record(1, 100, 149);
  EXPECT_TRUE(Said().empty());
  Record(1, 100, 147);
  ASSERT_EQ(Said().size(), 1u);
  EXPECT_THAT(Said()[0], testing::HasSubstr("odometry covers only 48 % of the scans"));
  Record(1, 0, 1000);
  EXPECT_TRUE(Said().empty());
  signals_[1].samples.clear();
  EXPECT_TRUE(Said().empty());
  Record(1, 0, 10);
  signals_[0].samples.clear();
  EXPECT_TRUE(Said().empty());
}

}  // namespace nightmap::common_time_test
