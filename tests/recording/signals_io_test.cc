// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/signals_io.h"

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::signals_io_test {

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

// A file of two samples.
using Offsets = std::vector<std::int64_t>;
struct Arrays {
  std::vector<double> pose = {0, 0, 0, 0, 0, 0, 1}, value = {0, 0, 0, 1, 1, 1};
  Offsets sample_offset = {0, 2}, time_ns = {5, 6}, range_offset = {0, 0, 0};
  std::vector<float> range_m;
};

class SignalsDamageTest : public testing::Test {
 protected:
  template <typename Damage>
  void ExpectRefused(const std::string& why, const Damage& damage) const {
    Arrays a;
    damage(a);
    const auto path = folder_ / "bad.h5";
    {
      Hdf5Writer file(path, "nightmap signals", 1, "config", "units");
      file.WriteText("kind", "odometry");
      file.WriteText("sensor_0", "wheels");
      file.Write("robot_from_sensor", Array<double>{1, 7, a.pose});
      file.WriteList("sample_offset", a.sample_offset);
      file.WriteList("time_ns", a.time_ns);
      file.Write("value", Array<double>{a.value.size() / 3, 3, a.value});
      file.WriteList("range_offset", a.range_offset);
      file.WriteList("range_m", a.range_m);
      file.Close();
    }
    NIGHTMAP_EXPECT_ERROR(DataError, ReadSignals(path, SignalKind::kOdometry), why);
  }

  TemporaryFolder folder_;
};

TEST_F(SignalsDamageTest, IsRefusedByTheNameOfTheArray) {
  ExpectRefused("value", [](Arrays& a) { a.value[4] = std::nan(""); });
  ExpectRefused("'time_ns' does not increase", [](Arrays& a) { a.time_ns = {6, 5}; });
  ExpectRefused("value", [](Arrays& a) { a.value.resize(3); });
  ExpectRefused("range_offset", [](Arrays& a) { a.range_offset = {0, 0}; });
  for (const Offsets& offsets :
       {Offsets{}, {0}, {0, 1}, {0, 3}, {-1, 2}, {1, 2}, {0, std::int64_t{1} << 62}, {0, 2, 2}}) {
    ExpectRefused("sample_offset", [&](Arrays& a) { a.sample_offset = offsets; });
  }
  ExpectRefused("'range_m' is of scans only", [](Arrays& a) {
    a.range_offset = {0, 1, 1};
    a.range_m = {1};
  });
  ExpectRefused("bad.h5", [](Arrays& a) { a.pose[6] = 0.5; });
}

}  // namespace nightmap::signals_io_test
