// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/signals_io.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap {
namespace signals_io_test {

std::vector<Signal> Scans() {
  Signal front{SignalKind::kScan, "front", {Eigen::Quaterniond::Identity(), {0.2, 0, 0.3}}, {}};
  for (int i = 0; i < 5; ++i) {
    front.samples.push_back({1'000'000'000 + i, {-1.5, 0.01, 30}, {}});
    front.samples.back().ranges_m.assign(static_cast<std::size_t>(3 + i),
                                         1.5f + static_cast<float>(i));
  }
  Signal silent{SignalKind::kScan, "rear, \"2\"", {}, {}};
  return {front, silent};
}

void ExpectSame(const std::vector<Signal>& a, const std::vector<Signal>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].sensor_id, b[i].sensor_id);
    EXPECT_EQ(a[i].scan_duration_s, b[i].scan_duration_s);
    EXPECT_EQ(a[i].robot_from_sensor.translation, b[i].robot_from_sensor.translation);
    ASSERT_EQ(a[i].samples.size(), b[i].samples.size());
    for (std::size_t k = 0; k < a[i].samples.size(); ++k) {
      EXPECT_EQ(a[i].samples[k].time_ns, b[i].samples[k].time_ns);
      EXPECT_EQ(a[i].samples[k].value, b[i].samples[k].value);
      EXPECT_EQ(a[i].samples[k].ranges_m, b[i].samples[k].ranges_m);
    }
  }
}

TEST(SignalsIo, WhatIsWrittenIsReadAndEqualSignalsGiveEqualBytes) {
  const TemporaryFolder folder;
  const auto path = folder / "scans.h5";
  WriteSignals(path, SignalKind::kScan, Scans());
  ExpectSame(ReadSignals(path, SignalKind::kScan), Scans());
  WriteSignals(folder / "again.h5", SignalKind::kScan, Scans());
  EXPECT_EQ(ReadBytes(path), ReadBytes(folder / "again.h5"));
  EXPECT_FALSE(Hdf5Reader(path, "nightmap signals", 1).Has("scan_duration_s"));
  auto turning = Scans();
  turning[1].scan_duration_s = 0.075;
  WriteSignals(path, SignalKind::kScan, turning);
  ExpectSame(ReadSignals(path, SignalKind::kScan), turning);
  WriteSignals(path, SignalKind::kOdometry, {});
  EXPECT_TRUE(ReadSignals(path, SignalKind::kOdometry).empty());
}

TEST(SignalsIo, AnotherKindIsRefused) {
  const TemporaryFolder folder;
  const auto path = folder / "scans.h5";
  WriteSignals(path, SignalKind::kScan, Scans());
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadSignals(path, SignalKind::kOdometry),
                        "field 'kind' is another kind of signal");
}

TEST(SignalKinds, EachHasARowThatItsNameFinds) {
  for (const SignalKindRow& row : SignalKinds()) {
    EXPECT_EQ(KindOf(row.name), row.kind);
    EXPECT_EQ(&RowOf(row.kind), &row);
  }
  EXPECT_EQ(KindOf("magnetic"), std::nullopt);
  EXPECT_THROW(RowOf(static_cast<SignalKind>(99)), std::logic_error);
}

// A file of two samples, with one array replaced.
class SignalsDamageTest : public testing::Test {
 protected:
  void ExpectRefused(const std::string& why) const {
    const auto path = folder_ / "bad.h5";
    {
      Hdf5Writer file(path, "nightmap signals", 1, "config", "units");
      file.WriteText("kind", kind_);
      file.WriteText("sensor_0", "wheels");
      file.Write("robot_from_sensor", Array<double>{1, 7, pose_});
      file.WriteList("sample_offset", sample_offset_);
      file.WriteList("time_ns", time_ns_);
      file.Write("value", Array<double>{value_.size() / 3, 3, value_});
      file.WriteList("range_offset", range_offset_);
      file.WriteList("range_m", range_m_);
      file.Close();
    }
    NIGHTMAP_EXPECT_ERROR(DataError, ReadSignals(path, SignalKind::kOdometry), why);
  }

  TemporaryFolder folder_;
  std::string kind_ = "odometry";
  std::vector<double> pose_ = {0, 0, 0, 0, 0, 0, 1};
  std::vector<std::int64_t> sample_offset_ = {0, 2}, time_ns_ = {5, 6}, range_offset_ = {0, 0, 0};
  std::vector<double> value_ = {0, 0, 0, 1, 1, 1};
  std::vector<float> range_m_;
};

TEST_F(SignalsDamageTest, ValuesThatAreNoNumbers) {
  value_[4] = std::nan("");
  ExpectRefused("value");
}
TEST_F(SignalsDamageTest, TimesThatGoBackwards) {
  time_ns_ = {6, 5};
  ExpectRefused("'time_ns' does not increase");
}
TEST_F(SignalsDamageTest, SizesThatDoNotAddUp) {
  value_.resize(3);
  ExpectRefused("value");
  value_ = {0, 0, 0, 1, 1, 1};
  range_offset_ = {0, 0};
  ExpectRefused("range_offset");
  range_offset_ = {0, 0, 0};
  for (const auto& offsets : std::vector<std::vector<std::int64_t>>{
           {}, {0}, {0, 1}, {0, 3}, {-1, 2}, {1, 2}, {0, std::int64_t{1} << 62}, {0, 2, 2}}) {
    sample_offset_ = offsets;
    ExpectRefused("sample_offset");
  }
}
TEST_F(SignalsDamageTest, RangesOfWhatIsNoScan) {
  range_offset_ = {0, 1, 1};
  range_m_ = {1};
  ExpectRefused("'range_m' is of scans only");
}
TEST_F(SignalsDamageTest, APoseThatIsNone) {
  pose_[6] = 0.5;
  ExpectRefused("bad.h5");
}

}  // namespace signals_io_test
}  // namespace nightmap
