// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/scan_queries_io.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::scan_queries_io_test {

std::vector<ScanQuery> Queries() {
  ScanQuery single{"kitchen, \"2\" ä", 5, {}, RoughPosition{{1.5, -2}, 5}};
  single.scans.push_back({{0.1, {0.2, 0.3}}, -1.5, 0.01, 30, {1, 2, 0, 30}});
  ScanQuery turn{"turn", 7, {}, {}};
  for (int i = 0; i < 3; ++i) {
    turn.scans.push_back({{0.5 * i, {0, 0}}, -1.5, 0.5, 30, {}});
    turn.scans.back().ranges_m.assign(static_cast<std::size_t>(i), 3.5F);
  }
  return {single, turn, {"nothing", 9, {}, {}}};
}

void ExpectSame(const std::vector<ScanQuery>& a, const std::vector<ScanQuery>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].time_ns, b[i].time_ns);
    ASSERT_EQ(a[i].rough_position.has_value(), b[i].rough_position.has_value());
    if (a[i].rough_position) {
      EXPECT_EQ(a[i].rough_position->point_in_map, b[i].rough_position->point_in_map);
      EXPECT_EQ(a[i].rough_position->radius_m, b[i].rough_position->radius_m);
    }
    ASSERT_EQ(a[i].scans.size(), b[i].scans.size());
    for (std::size_t k = 0; k < a[i].scans.size(); ++k) {
      const QueryScan &x = a[i].scans[k], &y = b[i].scans[k];
      EXPECT_EQ(x.query_from_laser.heading_rad, y.query_from_laser.heading_rad);
      EXPECT_EQ(x.query_from_laser.translation, y.query_from_laser.translation);
      EXPECT_EQ(x.first_angle_rad, y.first_angle_rad);
      EXPECT_EQ(x.step_angle_rad, y.step_angle_rad);
      EXPECT_EQ(x.limit_m, y.limit_m);
      EXPECT_EQ(x.ranges_m, y.ranges_m);
    }
  }
}

TEST(ScanQueriesIo, WhatIsWrittenIsReadAndEqualQueriesGiveEqualBytes) {
  const TemporaryFolder folder;
  WriteScanQueries(folder / "a.h5", Queries());
  ExpectSame(ReadScanQueries(folder / "a.h5"), Queries());
  WriteScanQueries(folder / "b.h5", Queries());
  EXPECT_EQ(ReadBytes(folder / "a.h5"), ReadBytes(folder / "b.h5"));
  WriteScanQueries(folder / "none.h5", {});
  EXPECT_TRUE(ReadScanQueries(folder / "none.h5").empty());
}

TEST(ScanQueriesIo, RangesThatAreNoNumbersAreWrittenAsNothingHit) {
  const TemporaryFolder folder;
  auto queries = Queries();
  queries[0].scans[0].ranges_m = {std::nanf(""), std::numeric_limits<float>::infinity(), 2};
  WriteScanQueries(folder / "a.h5", queries);
  const std::vector<float> expected = {0, 0, 2};
  EXPECT_EQ(ReadScanQueries(folder / "a.h5")[0].scans[0].ranges_m, expected);
}

TEST(ScanQueriesIo, PointsAreThoseOfHitsInTheFrameOfTheQuery) {
  ScanQuery query{"a", 0, {}, {}};
  constexpr double kQuarter_rad = std::numbers::pi / 2;
  query.scans.push_back({{kQuarter_rad, {1, 0}}, 0, kQuarter_rad, 10, {2, 3, 10, 0, 8}});
  const auto points = PointsInQuery(query, 5);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_LT((points[0] - Eigen::Vector2d(1, 2)).norm(), 1e-6);
  EXPECT_LT((points[1] - Eigen::Vector2d(-2, 0)).norm(), 1e-6);
  EXPECT_EQ(PointsInQuery(query, 9).size(), 3U);
}

// A file of one query with one scan of two beams.
using Offsets = std::vector<std::int64_t>;
struct Arrays {
  Offsets name_offset = {0, 1}, scan_offset = {0, 1}, range_offset = {0, 2};
  std::vector<std::uint8_t> name = {'a'};
  std::vector<double> pose = {0, 0, 0}, beams = {0, 0.1, 30}, rough = {0, 0, 0};
};

class ScanQueriesDamageTest : public testing::Test {
 protected:
  template <typename Damage>
  void ExpectRefused(const std::string& why, const Damage& damage) const {
    Arrays a;
    damage(a);
    {
      Hdf5Writer file(folder_ / "bad.h5", "nightmap scan queries", 1, "", "");
      file.WriteList("name_offset", a.name_offset);
      file.WriteList("name", a.name);
      file.WriteList("time_ns", std::vector<std::int64_t>(a.name_offset.size() - 1, 4));
      file.WriteList("scan_offset", a.scan_offset);
      file.Write("query_from_laser", Array<double>{1, 3, a.pose});
      file.Write("beams", Array<double>{1, 3, a.beams});
      file.WriteList("range_offset", a.range_offset);
      file.WriteList("range_m", std::vector<float>{1, 2});
      file.Write("rough_position", Array<double>{a.rough.size() / 3, 3, a.rough});
      file.Close();
    }
    NIGHTMAP_EXPECT_ERROR(DataError, ReadScanQueries(folder_ / "bad.h5"), why);
  }

  TemporaryFolder folder_;
};

TEST_F(ScanQueriesDamageTest, IsRefusedByTheNameOfTheArray) {
  // NaN and places beyond any building
  ExpectRefused("query_from_laser", [](Arrays& a) { a.pose[1] = std::nan(""); });
  ExpectRefused("'query_from_laser' is too far from the robot", [](Arrays& a) { a.pose[1] = 1e4; });
  ExpectRefused("rough_position", [](Arrays& a) { a.rough[0] = -1e9; });
  ExpectRefused("rough_position", [](Arrays& a) { a.rough[2] = 1e9; });
  ExpectRefused("'rough_position' has a negative radius", [](Arrays& a) { a.rough[2] = -1; });
  ExpectRefused("rough_position", [](Arrays& a) { a.rough = {}; });  // one too few
  ExpectRefused("'beams' has an angle step of 0", [](Arrays& a) { a.beams[1] = 0; });
  for (const Offsets& offsets : {Offsets{0, 2}, {1, 1}, {0}, {0, -1}}) {
    ExpectRefused("scan_offset", [&](Arrays& a) { a.scan_offset = offsets; });
  }
  ExpectRefused("range_offset", [](Arrays& a) { a.range_offset = {0, 3}; });
  ExpectRefused("name", [](Arrays& a) { a.name[0] = '\n'; });
  ExpectRefused("name", [](Arrays& a) {
    a.name = {};
    a.name_offset = {0, 0};
  });
  ExpectRefused("'time_ns' does not increase", [](Arrays& a) {
    a.name = {'a', 'b'};
    a.name_offset = {0, 1, 2};
    a.scan_offset = {0, 1, 1};
    a.rough.resize(6);
  });
}

}  // namespace nightmap::scan_queries_io_test
