// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/hdf5_table.h"

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::hdf5_table_test {

enum class Kind : std::uint8_t { kPlain, kOther };

struct View {
  int image = 0;
  std::vector<float> depths_m;
};

struct Point {
  std::int64_t time_ns = 0;
  Kind kind = Kind::kPlain;
  bool is_seen = false;
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double size_m = 0;
  Rigid3 map_from_point;
  std::vector<View> views;
};

constexpr auto kPoints = Hdf5Table<Point>(
    Hdf5Column("time_ns", &Point::time_ns)
        .Elements(kNotNegative, "is before all time")
        .Pairs(Ascending(&Point::time_ns), "does not ascend"),
    Hdf5Column("kind", &Point::kind).Rows([](const Point& point) {
      return point.kind <= Kind::kOther;
    }),
    Hdf5Column("is_seen", &Point::is_seen),
    Hdf5Column("place", &Point::px, &Point::size_m).Elements([](double v) { return v < 100; }),
    Hdf5Column("map_from_point", &Point::map_from_point),
    Hdf5Lists<std::int32_t>(
        "first_view",
        &Point::views,
        Hdf5Table<View>(
            Hdf5Lists(
                "first_depth", &View::depths_m, Hdf5Table<float>(Hdf5Column("depth_m", kItself))),
            Hdf5Column("view_image", &View::image))));

// Three points with two views, one and none.
std::vector<Point> SomePoints() {
  std::vector<Point> points(3);
  for (int i = 0; i < 3; ++i) {
    Point& point = points[static_cast<std::size_t>(i)];
    point.time_ns = 10 * i;
    point.px = {i, 0.5};
    point.size_m = 7;
    point.map_from_point.translation.x() = i;
  }
  points[1].kind = Kind::kOther;
  points[1].is_seen = true;
  points[0].views = {{4, {1, 2}}, {5, {}}};
  points[1].views = {{6, {3}}};
  return points;
}

class Hdf5TableTest : public testing::Test {
 protected:
  void Write(const std::vector<Point>& points) const {
    Hdf5Writer file(path_, "points", 1, "", "");
    kPoints.Write(points, &file);
    file.Close();
  }
  std::vector<Point> Read() const { return kPoints.Read(Hdf5Reader(path_, "points", 1)); }

  void ExpectRefused(const std::function<void(std::vector<Point>&)>& damage,
                     const std::string& text) const {
    auto points = SomePoints();
    damage(points);
    Write(points);
    NIGHTMAP_EXPECT_ERROR(DataError, Read(), "a.h5: " + text);
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "a.h5";
};

TEST_F(Hdf5TableTest, ArraysHaveTheRowsOneBelowTheOther) {
  Write(SomePoints());
  const Hdf5Reader file(path_, "points", 1);
  EXPECT_EQ(file.ReadList<std::int64_t>("time_ns"), (std::vector<std::int64_t>{0, 10, 20}));
  EXPECT_EQ(file.ReadList<std::uint8_t>("kind"), (std::vector<std::uint8_t>{0, 1, 0}));
  EXPECT_EQ(file.ReadList<std::uint8_t>("is_seen"), (std::vector<std::uint8_t>{0, 1, 0}));
  EXPECT_EQ(file.Read<double>("place", 3).values,
            (std::vector<double>{0, 0.5, 7, 1, 0.5, 7, 2, 0.5, 7}));
  const auto poses = file.Read<double>("map_from_point", 7).values;
  EXPECT_EQ(std::vector<double>(poses.begin() + 7, poses.begin() + 14),
            (std::vector<double>{1, 0, 0, 0, 0, 0, 1}));
  EXPECT_EQ(file.ReadList<std::int32_t>("first_view"), (std::vector<std::int32_t>{0, 2, 3, 3}));
  EXPECT_EQ(file.ReadList<std::int64_t>("first_depth"), (std::vector<std::int64_t>{0, 2, 2, 3}));
  EXPECT_EQ(file.ReadList<float>("depth_m"), (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(file.ReadList<std::int32_t>("view_image"), (std::vector<std::int32_t>{4, 5, 6}));
}

TEST_F(Hdf5TableTest, WhatIsReadIsWrittenAlike) {
  for (const auto& points : {SomePoints(), std::vector<Point>{}}) {
    Write(points);
    const std::string bytes = ReadBytes(path_);
    const auto read = Read();
    ASSERT_EQ(read.size(), points.size());
    Write(read);
    EXPECT_EQ(ReadBytes(path_), bytes);
  }
}

TEST_F(Hdf5TableTest, ChecksNameTheArrayAndSayWhy) {
  using Points = std::vector<Point>;
  ExpectRefused([](Points& p) { p[0].time_ns = -1; }, "field 'time_ns' is before all time");
  ExpectRefused([](Points& p) { p[2].time_ns = 10; }, "field 'time_ns' does not ascend");
  ExpectRefused([](Points& p) { p[2].kind = Kind{2}; }, "field 'kind' is out of range");
  for (const std::size_t i : {0U, 2U}) {
    ExpectRefused([&](Points& p) { p[i].px.y() = 100; }, "field 'place' is out of range");
    ExpectRefused([&](Points& p) { p[i].size_m = 100; }, "field 'place' is out of range");
  }
  ExpectRefused([](Points& p) { p[2].map_from_point.rotation.w() = 2; },
                "row 2 holds a quaternion that is not of unit length in field 'map_from_point'");
}

// Files of another program.
TEST_F(Hdf5TableTest, ArraysThatAreMissingOrOfOtherSizesAreNamed) {
  constexpr auto kTwo = Hdf5Table<Point>(Hdf5Column("time_ns", &Point::time_ns),
                                         Hdf5Column("is_seen", &Point::is_seen));
  const auto expect_refused = [&](const std::vector<std::uint8_t>& is_seen, const char* text) {
    Hdf5Writer file(path_, "points", 1, "", "");
    file.WriteList<std::int64_t>("time_ns", {1, 2});
    if (!is_seen.empty()) file.WriteList("is_seen", is_seen);
    file.Close();
    NIGHTMAP_EXPECT_ERROR(DataError, kTwo.Read(Hdf5Reader(path_, "points", 1)), text);
  };
  expect_refused({}, "a.h5: field 'is_seen' is missing");
  expect_refused({0}, "a.h5: field 'is_seen' has another length than the others");
  expect_refused({0, 1, 1}, "a.h5: field 'is_seen' has another length than the others");
  expect_refused({0, 2}, "a.h5: row 1 holds a flag that is neither 0 nor 1 in field 'is_seen'");
}

TEST_F(Hdf5TableTest, ListsThatDoNotCoverTheirItemsAreNamed) {
  constexpr auto kLists =
      Hdf5Lists("first", &View::depths_m, Hdf5Table<float>(Hdf5Column("depth_m", kItself)));
  const auto refuse = [&](const std::vector<std::int64_t>& first, const auto& table) {
    Hdf5Writer file(path_, "points", 1, "", "");
    file.WriteList<std::int32_t>("image", {7});
    file.WriteList("first", first);
    file.WriteList<float>("depth_m", {1, 2});
    file.Close();
    NIGHTMAP_EXPECT_ERROR(
        DataError, table.Read(Hdf5Reader(path_, "points", 1)), "a.h5: field 'first'");
  };
  const auto after = Hdf5Table<View>(Hdf5Column("image", &View::image), kLists);
  using Offsets = std::vector<std::int64_t>;
  for (const Offsets& first : {Offsets{}, {2}, {0, 1}, {0, 3}, {1, 2}, {0, 3, 2}, {0, -1, 2}}) {
    refuse(first, after);
    refuse(first, Hdf5Table<View>(kLists));
  }
  refuse({0, 1, 2}, after);
}

}  // namespace nightmap::hdf5_table_test
