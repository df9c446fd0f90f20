// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/things_io.h"

#include <limits>
#include <sstream>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::things_io_test {

std::vector<Thing> TwoThings() {
  Thing sofa;
  sofa.name = "sofa_1";
  sofa.class_name = "sofa";
  sofa.map_from_thing = {-2.0 / 3, {1.0 / 3, -4.25}};
  sofa.bottom_m = 0.1;
  sofa.size_m = {0.9, 2.1, 1.0 / 7};
  sofa.num_views = 12;
  sofa.confidence = 0.875;
  sofa.best_view = {1305031102175304001, "a \"b\"/\xC3\xA9.jpg", {3, 0, 640, 480}};
  Thing chair = sofa;
  chair.name = "armchair_1";
  chair.class_name = "arm chair";
  chair.num_views = 0;
  chair.best_view.reset();
  return {sofa, chair};
}

class ThingsIoTest : public testing::Test {
 protected:
  // The file with one text replaced is refused, and the message names it.
  void ExpectRefused(const std::string& from, const std::string& to, const std::string& part) {
    std::string text = ThingsToJson(TwoThings());
    ASSERT_NE(text.find(from), std::string::npos) << from;
    WriteFile(path_, text.replace(text.find(from), from.size(), to));
    NIGHTMAP_EXPECT_ERROR(DataError, ReadThings(path_), part, path_.string());
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "things.json";
};

TEST_F(ThingsIoTest, WhatIsWrittenIsReadToTheLastBit) {
  const std::vector<Thing> written = TwoThings();
  WriteFile(path_, ThingsToJson(written));
  const std::vector<Thing> read = ReadThings(path_);
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Thing &a = read[i], &b = written[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.class_name, b.class_name);
    EXPECT_EQ(a.map_from_thing.heading_rad, b.map_from_thing.heading_rad);
    EXPECT_EQ(a.map_from_thing.translation, b.map_from_thing.translation);
    EXPECT_EQ(a.bottom_m, b.bottom_m);
    EXPECT_EQ(a.size_m, b.size_m);
    EXPECT_EQ(a.num_views, b.num_views);
    EXPECT_EQ(a.confidence, b.confidence);
    ASSERT_EQ(a.best_view.has_value(), b.best_view.has_value());
    if (!a.best_view) continue;
    EXPECT_EQ(a.best_view->time_ns, b.best_view->time_ns);
    EXPECT_EQ(a.best_view->color_path, b.best_view->color_path);
    EXPECT_EQ(a.best_view->rectangle_px, b.best_view->rectangle_px);
  }
}

TEST_F(ThingsIoTest, EqualThingsAreEqualBytes) {
  EXPECT_EQ(ThingsToJson(TwoThings()), ThingsToJson(TwoThings()));
  WriteFile(path_, ThingsToJson(TwoThings()));
  EXPECT_EQ(ThingsToJson(ReadThings(path_)), ThingsToJson(TwoThings()));
}

TEST_F(ThingsIoTest, NoThingsAreAList) {
  WriteFile(path_, ThingsToJson({}));
  EXPECT_TRUE(ReadThings(path_).empty());
}

TEST_F(ThingsIoTest, AThingIsALine) {
  std::istringstream text(ThingsToJson(TwoThings()));
  int num_named = 0;
  for (std::string line; std::getline(text, line);) {
    num_named += line.find("\"name\":") != std::string::npos;
  }
  EXPECT_EQ(num_named, 2);
}

TEST_F(ThingsIoTest, EveryTruncationIsRefused) {
  const std::string text = ThingsToJson(TwoThings());
  for (std::size_t size = 0; size + 2 < text.size(); size += 7) {
    WriteFile(path_, text.substr(0, size));
    EXPECT_THROW(ReadThings(path_), DataError) << size << " of " << text.size() << " bytes";
  }
  std::filesystem::remove(path_);
  EXPECT_THROW(ReadThings(path_), DataError);
}

TEST_F(ThingsIoTest, OtherFormatsAreRefused) {
  ExpectRefused("nightmap_things", "nightmap tile", "format");
  ExpectRefused("\"version\": 1", "\"version\": 2", "newer");
  ExpectRefused("\"version\": 1", "\"version\": 0", "version is 0");
  ExpectRefused("\"things\": [", "\"objects\": [", "things");
  ExpectRefused("\"things\": [", "\"things\": 3, \"others\": [", "no list");
}

TEST_F(ThingsIoTest, EveryKeyMustBeThere) {
  for (const std::string key : {"name",
                                "class",
                                "x_m",
                                "y_m",
                                "heading_rad",
                                "bottom_m",
                                "size_m",
                                "num_views",
                                "confidence",
                                "time_ns",
                                "color_path",
                                "rectangle_px"}) {
    ExpectRefused("\"" + key + "\":", "\"other\":", "'" + key + "'");
    ExpectRefused("\"" + key + "\":", "\"other\":", "thing 1");
    ExpectRefused("\"" + key + "\":", "\"" + key + "\": null, \"other\":", "thing 1");
  }
}

TEST_F(ThingsIoTest, NumbersThatAreNotFiniteAreRefused) {
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<Thing> things = TwoThings();
    things[1].size_m.y() = value;
    WriteFile(path_, ThingsToJson(things));
    NIGHTMAP_EXPECT_ERROR(DataError, ReadThings(path_), "thing 2 ('armchair_1')");
    things = TwoThings();
    things[1].map_from_thing.translation.x() = value;
    WriteFile(path_, ThingsToJson(things));
    NIGHTMAP_EXPECT_ERROR(DataError, ReadThings(path_), "thing 2 ('armchair_1')");
  }
  ExpectRefused("\"y_m\":-4.25", "\"y_m\":NaN", "parse error");
  ExpectRefused("\"y_m\":-4.25", "\"y_m\":1e999", "overflow");
}

TEST_F(ThingsIoTest, NumbersOutOfRangeAreRefused) {
  ExpectRefused("\"y_m\":-4.25", "\"y_m\":-1e200", "y_m is");
  ExpectRefused("\"y_m\":-4.25", "\"y_m\":\"far\"", "number");
  ExpectRefused("\"size_m\":[0.9,", "\"size_m\":[0,", "size_m is not above 0");
  ExpectRefused("\"size_m\":[0.9,", "\"size_m\":[-0.9,", "size_m is not above 0");
  ExpectRefused("\"size_m\":[0.9,", "\"size_m\":[0.9,0.9,", "4 numbers");
  ExpectRefused("\"confidence\":0.875", "\"confidence\":1.5", "confidence is 1.5");
  for (const std::string wrong : {"-1", "4294967297", "18446744073709551615", "1e300", "0.5"}) {
    ExpectRefused("\"num_views\":12", "\"num_views\":" + wrong, "num_views is");
    ExpectRefused("[3,0,640,480]", "[3,0,640," + wrong + "]", "bottom is");
  }
  ExpectRefused("[3,0,640,480]", "[3,0,3,480]", "no extent");
  ExpectRefused("[3,0,640,480]", "[3,0,640]", "no list of 4");
  for (const std::string wrong : {"18446744073709551615", "1e3", "0.5"}) {
    ExpectRefused("1305031102175304001", wrong, "no integer");
  }
}

TEST_F(ThingsIoTest, NamesAreUnique) {
  ExpectRefused("\"name\":\"armchair_1\"", "\"name\":\"sofa_1\"", "thing 2 ('sofa_1'): the name");
  ExpectRefused("\"name\":\"sofa_1\"", "\"name\":\"\"", "name is empty");
  ExpectRefused("\"class\":\"sofa\"", "\"class\":\"\"", "class is empty");
}

TEST_F(ThingsIoTest, NamesThatAreNoTextAreRefusedByName) {
  std::vector<Thing> things = TwoThings();
  things[0].best_view->color_path = "caf\xE9.jpg";
  NIGHTMAP_EXPECT_ERROR(DataError, ThingsToJson(things), "sofa_1");
}

}  // namespace nightmap::things_io_test
