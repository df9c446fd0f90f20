// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/objects_io.h"

#include <numbers>

#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::objects_io_test {

MapObject Column() { return {"column 1", {std::numbers::pi / 6, {1.25, 3.4}}, {0.8, 0.6}, 0.83}; }

const std::string kHead = "format: nightmap objects\nversion: 1\n";
const std::string kColumn =
    "  - name: \"column 1\"\n    x_m: 1.25\n    y_m: 3.4\n    size_x_m: 0.8\n    size_y_m: 0.6\n"
    "    angle_deg: 30\n    distinctiveness: 0.83\n";

class ObjectsFile : public testing::Test {
 protected:
  std::vector<MapObject> Read(const std::string& text) const {
    WriteFile(path_, text);
    return ReadObjects(path_);
  }
  // The message names the file, then the line and the reason.
  void ExpectRefused(const std::string& text, const std::string& line_and_reason) const {
    SCOPED_TRACE(text);
    NIGHTMAP_EXPECT_ERROR(DataError, Read(text), path_.string() + ":" + line_and_reason);
  }
  // The column with one of its lines replaced.
  std::string With(const std::string& line, const std::string& instead) const {
    std::string text = kHead + "objects:\n" + kColumn;
    return text.replace(text.find(line), line.size(), instead);
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.Path() / "objects.yaml";
};

void ExpectSame(const MapObject& a, const MapObject& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.map_from_object.translation, b.map_from_object.translation);
  EXPECT_NEAR(a.map_from_object.heading_rad, b.map_from_object.heading_rad, 1e-10);
  EXPECT_EQ(a.size_m, b.size_m);
  EXPECT_EQ(a.distinctiveness, b.distinctiveness);
}

TEST_F(ObjectsFile, IsWrittenAsPeopleWriteIt) {
  EXPECT_EQ(ObjectsToYaml({Column()}), kHead + "objects:\n" + kColumn);
  EXPECT_EQ(ObjectsToYaml({}), kHead + "objects: []\n");
}

TEST_F(ObjectsFile, ReadsBackWhatItWrote) {
  Random random(7);
  std::vector<MapObject> objects = {Column()};
  for (int i = 0; i < 50; ++i) {
    objects.push_back({"object " + std::to_string(i),
                       {random.Uniform(-3, 3), {random.Uniform(-99, 99), random.Uniform(-1e-9, 1)}},
                       {random.Uniform(1e-6, 9), random.Uniform(0.1, 9)},
                       {}});
    if (i % 2 == 0) objects.back().distinctiveness = random.Uniform(0, 1);
  }
  const std::string yaml = ObjectsToYaml(objects);
  const auto read = Read(yaml);
  ASSERT_EQ(read.size(), objects.size());
  for (std::size_t i = 0; i < objects.size(); ++i) ExpectSame(read[i], objects[i]);
  EXPECT_EQ(ObjectsToYaml(read), yaml);
  EXPECT_TRUE(Read(ObjectsToYaml({})).empty());
}

TEST_F(ObjectsFile, NamesMayHoldAnyCharacterButControls) {
  std::vector<MapObject> objects;
  for (const std::string name : {"a: b # c",
                                 "\"quoted\" \\ 'both'",
                                 " - spaces ",
                                 "柱子",
                                 "🏛",
                                 "\u2028\u2029\uFEFF\u00A0",
                                 "~",
                                 "null",
                                 "1.5",
                                 "*alias",
                                 "{}",
                                 "%"}) {
    objects.push_back(Column());
    objects.back().name = name;
  }
  const auto read = Read(ObjectsToYaml(objects));
  ASSERT_EQ(read.size(), objects.size());
  for (std::size_t i = 0; i < objects.size(); ++i) EXPECT_EQ(read[i].name, objects[i].name);
  EXPECT_NE(ObjectsToYaml(objects).find("柱子"), std::string::npos);
  for (const std::string name :
       {"line\nbreak", "tab\t", "\r", "\x1b[31m", "\a", "\x7f", "\u0085", "\u009b"}) {
    objects.back().name = name;
    NIGHTMAP_EXPECT_ERROR(DataError, Read(ObjectsToYaml(objects)), "holds control characters");
  }
}

TEST_F(ObjectsFile, ANameThatIsNotUtf8IsRefused) {
  for (const std::string name :
       {"\xFF", "\xC0\x80", "\xED\xA0\x80", "\xE2\x82", "\xF4\x90\x80\x80"}) {
    MapObject object = Column();
    object.name = "caf" + name;
    NIGHTMAP_EXPECT_ERROR(DataError, ObjectsToYaml({object}), "is not UTF-8");
    ExpectRefused(With("column 1", "caf" + name), "4: not UTF-8");
  }
}

TEST_F(ObjectsFile, ReadsWhatPeopleMakeOfIt) {
  const auto read = Read(
      "# mine\r\n---\r\nversion: 1\r\nobjects:\r\n- {name: Säule, x_m: +1, y_m: 2,"
      " size_x_m: '3', size_y_m: 1e-1, angle_deg: -90}  # a flow\r\n"
      "format: 'nightmap objects'\r\n");
  ASSERT_EQ(read.size(), 1u);
  ExpectSame(read[0], {"Säule", {-std::numbers::pi / 2, {1, 2}}, {3, 0.1}, {}});
}

TEST_F(ObjectsFile, NamesFileAndLineOfWhatIsWrong) {
  ExpectRefused(With("y_m: 3.4", "y: 3.4"), "6: unknown key 'y'; known: angle_deg, dist");
  ExpectRefused(With("    y_m: 3.4\n", ""), "4: missing key 'y_m'");
  ExpectRefused(With("y_m: 3.4", "y_m: 3.4\n    x_m: 1.25"), "7: key 'x_m' appears twice");
  ExpectRefused(With("3.4", ".nan"), "6: y_m is '.nan', not a finite number");
  ExpectRefused(With("3.4", "nan"), "6: y_m is 'nan', not a finite number");
  ExpectRefused(With("3.4", ".inf"), "6: y_m is '.inf'");
  ExpectRefused(With("3.4", "1e999"), "6: y_m is '1e999'");
  ExpectRefused(With("3.4", "3.4 m"), "6: y_m is '3.4 m'");
  ExpectRefused(With("3.4", "[3.4]"), "6: y_m is not a single value");
  ExpectRefused(With("3.4", ""), "6: y_m has no value");
  ExpectRefused(With("3.4", "1e9"), "6: y_m is 1e9, not in");
  ExpectRefused(With("0.6", "0"), "8: size_y_m is 0, not above 0");
  ExpectRefused(With("0.8", "-1"), "7: size_x_m is -1, not above 0");
  ExpectRefused(With("angle_deg: 30", "angle_deg: 400"), "9: angle_deg is 400, not in");
  ExpectRefused(With("0.83", "1.1"), "10: distinctiveness is 1.1, not in [0, 1]");
  ExpectRefused(With("column 1", ""), "4: name is empty");
  ExpectRefused(With("column 1", "a\\e[31m"), "4: name 'a\\x1b[31m' holds control characters");
  ExpectRefused(kHead + "objects:\n" + kColumn + kColumn, "11: name 'column 1' appears twice");
  ExpectRefused(kHead + "objects:\n" + kColumn + "objects: []\n",
                "11: key 'objects' appears twice");
  ExpectRefused(kHead + "objects: 3\n", "3: objects is not a list");
  ExpectRefused(kHead + "objects: [3]\n", "3: expected keys and values");
  ExpectRefused(kHead + "objects: [\n", "4: not valid YAML: ");
  ExpectRefused(kHead, "1: missing key 'objects'");
  ExpectRefused("", "1: expected one YAML document");
  ExpectRefused(kHead + "objects: []\n---\n" + kHead, "1: expected one YAML document");
  ExpectRefused("format: nightmap tiles\nversion: 1\nobjects: []\n", "1: format is not");
  ExpectRefused("format: nightmap objects\nversion: 2\nobjects: []\n",
                "2: version 2, this program reads 1");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadObjects(folder_.Path() / "none.yaml"), "none.yaml");
}

// YAML has no end mark: what is cut off in the last number or between objects passes for the whole.
TEST_F(ObjectsFile, ATruncatedFileIsRefusedOrEndsEarlier) {
  MapObject second = Column();
  second.name = "b";
  const std::string whole = ObjectsToYaml({Column(), second});
  std::size_t num_refused = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    try {
      const auto read = Read(whole.substr(0, size));
      ASSERT_FALSE(read.empty());
      ASSERT_LE(read.size(), 2u);
      if (read.size() == 2) ExpectSame(read[0], Column());
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(path_.string() + ":"));
      ++num_refused;
    }
  }
  EXPECT_GT(num_refused, whole.size() / 2);
}

TEST_F(ObjectsFile, HostileYamlIsRefused) {
  EXPECT_THROW(Read(std::string(100000, '[')), DataError);
  EXPECT_THROW(Read(std::string(100000, '{')), DataError);
  EXPECT_THROW(Read(kHead + "objects: &o [*o]\n"), DataError);
  EXPECT_THROW(Read(kHead + "objects: *o\n"), DataError);
  EXPECT_THROW(Read(kHead + "? [objects]\n: []\n"), DataError);
  EXPECT_THROW(Read(kHead + "objects:\n" + kColumn + "  - <<: *c\n"), DataError);
}

TEST(Objects, SidesAreCutAboutTheCenter) {
  std::vector<MapObject> objects = {Column(), Column(), Column()};
  objects[1].name = "hall";
  objects[1].size_m = {7, 0.5};
  objects[2].size_m = {4, 4};
  const auto notices = ClampObjects(4, &objects);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_EQ(notices[0], "object 'hall' is cut from 7.00 x 0.50 m to 4.00 x 0.50 m");
  EXPECT_EQ(objects[1].size_m, Eigen::Vector2d(4, 0.5));
  EXPECT_EQ(objects[1].map_from_object.translation, Column().map_from_object.translation);
  ExpectSame(objects[0], Column());
  EXPECT_TRUE(ClampObjects(4, &objects).empty());
}

TEST(Objects, ContainWhatLiesInTheTurnedRectangle) {
  const MapObject object{"a", {std::numbers::pi / 6, {1, 2}}, {2, 1}, {}};
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d point(random.Uniform(-2, 2), random.Uniform(-1, 1));
    const bool is_inside = std::abs(point.x()) <= 1 && std::abs(point.y()) <= 0.5;
    EXPECT_EQ(Contains(object, object.map_from_object * point), is_inside) << point.transpose();
  }
  EXPECT_TRUE(Contains({"b", {}, {2, 1}, {}}, {1, 0.5}));
}

}  // namespace nightmap::objects_io_test
