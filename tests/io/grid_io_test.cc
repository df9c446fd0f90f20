// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/grid_io.h"

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::grid_io_test {

class GridIoTest : public testing::Test {
 protected:
  std::filesystem::path Yaml() const { return folder_ / "map.yaml"; }

  void Write(const std::string& yaml, const std::string& pgm) const {
    folder_.Write("map.yaml", yaml);
    folder_.Write("map.pgm", pgm);
  }

  void ExpectError(const std::string& yaml, const std::string& pgm, const std::string& part) const {
    Write(yaml, pgm);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadGrid(Yaml()), part, folder_.Path().string());
  }

  TemporaryFolder folder_;
};

OccupancyGrid RandomGrid(std::uint64_t seed) {
  Random random(seed);
  OccupancyGrid grid;
  grid.width = 1 + static_cast<int>(random.Index(40));
  grid.height = 1 + static_cast<int>(random.Index(40));
  grid.resolution_m = random.Uniform(0.01, 0.3);
  grid.origin_in_map = {random.Uniform(-90, 90), random.Uniform(-1e-7, 1e-7)};
  grid.origin_yaw_rad = seed % 2 == 0 ? 0 : random.Uniform(-3, 3);
  for (int i = 0; i < grid.width * grid.height; ++i) {
    grid.cells.push_back(static_cast<std::uint8_t>(random.Index(3)));
  }
  return grid;
}

const std::string kYaml =
    "image: map.pgm\nresolution: 0.05\norigin: [-1.5, 2, 0]\nnegate: 0\n"
    "occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: trinary\n";
const std::string kPgm = std::string("P5\n2 1\n255\n") + '\x00' + '\xfe';

std::string Replace(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST_F(GridIoTest, WhatIsWrittenIsRead) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const OccupancyGrid grid = RandomGrid(seed);
    Write(GridToYaml(grid, "map.pgm"), GridToPgm(grid));
    const OccupancyGrid read = ReadGrid(Yaml());
    EXPECT_EQ(read.width, grid.width);
    EXPECT_EQ(read.height, grid.height);
    EXPECT_EQ(read.resolution_m, grid.resolution_m);
    EXPECT_EQ(read.origin_in_map, grid.origin_in_map);
    EXPECT_EQ(read.origin_yaw_rad, grid.origin_yaw_rad);
    EXPECT_EQ(read.cells, grid.cells);
  }
}

TEST_F(GridIoTest, FirstImageRowIsLargestY) {
  OccupancyGrid grid;
  grid.width = 2;
  grid.height = 2;
  grid.cells = {kFreeCell, kOccupiedCell, kUnknownCell, kFreeCell};
  const std::string pgm = GridToPgm(grid);
  EXPECT_EQ(pgm, std::string("P5\n2 2\n255\n") + "\xcd\xfe\xfe" + '\x00');
}

TEST_F(GridIoTest, CellsAndPointsAgree) {
  const OccupancyGrid grid = RandomGrid(7);
  for (int y = -2; y < grid.height + 2; ++y) {
    for (int x = -2; x < grid.width + 2; ++x) {
      EXPECT_EQ(grid.CellOf(grid.CenterInMap({x, y})), Eigen::Vector2i(x, y));
    }
  }
  EXPECT_FALSE(grid.Contains(grid.CellOf({1e300, -1e300})));
}

// A quarter turn about the origin: the rows go up, the columns to the left.
TEST_F(GridIoTest, YawTurnsTheGridAboutItsOrigin) {
  Write(Replace(kYaml, "2, 0]", "2, 1.5707963267948966]"), kPgm);
  const OccupancyGrid grid = ReadGrid(Yaml());
  const Eigen::Vector2d second = grid.CenterInMap({1, 0});
  EXPECT_NEAR(second.x(), -1.5 - 0.025, 1e-12);
  EXPECT_NEAR(second.y(), 2 + 0.075, 1e-12);
  EXPECT_EQ(grid.CellOf({-1.52, 2.09}), Eigen::Vector2i(1, 0));
  EXPECT_FALSE(grid.Contains(grid.CellOf({-1.48, 2.09})));
}

TEST_F(GridIoTest, AppliesMapServerRules) {
  std::string pgm = "P5\n# CREATOR: another program\n256 1\n255\n";
  for (int gray = 0; gray < 256; ++gray) pgm.push_back(static_cast<char>(gray));
  Write(kYaml, pgm);
  const OccupancyGrid grid = ReadGrid(Yaml());
  Write(Replace(kYaml, "negate: 0", "negate: 1"), pgm);
  const OccupancyGrid negated = ReadGrid(Yaml());
  for (std::size_t gray = 0; gray < 256; ++gray) {
    const double p = (255.0 - static_cast<double>(gray)) / 255.0;
    const int expected = p > 0.65 ? kOccupiedCell : p < 0.196 ? kFreeCell : kUnknownCell;
    EXPECT_EQ(grid.cells[gray], expected) << gray;
    EXPECT_EQ(negated.cells[255 - gray], expected) << gray;
  }
  EXPECT_EQ(grid.cells[205], kUnknownCell);
}

TEST_F(GridIoTest, AppliesTheOtherModes) {
  std::string pgm = "P5\n256 1\n255\n";
  for (int gray = 0; gray < 256; ++gray) pgm.push_back(static_cast<char>(gray));
  Write(kYaml, pgm);
  const OccupancyGrid trinary = ReadGrid(Yaml());
  Write(Replace(kYaml, "trinary", "scale"), pgm);
  EXPECT_EQ(ReadGrid(Yaml()).cells, trinary.cells);
  Write(Replace(kYaml, "negate: 0", "negate: false"), pgm);
  EXPECT_EQ(ReadGrid(Yaml()).cells, trinary.cells);
  Write(Replace(kYaml, "trinary", "raw"), pgm);
  const OccupancyGrid raw = ReadGrid(Yaml());
  for (std::size_t gray = 0; gray < 256; ++gray) {
    const bool is_known = gray < 20 || (gray > 65 && gray <= 100);  // 0.196 and 0.65 of 100
    const int expected = gray < 20 ? kFreeCell : kOccupiedCell;
    EXPECT_EQ(raw.cells[gray], is_known ? expected : kUnknownCell) << gray;
  }
}

TEST_F(GridIoTest, PictureHasTheBytesOfThePgm) {
  const OccupancyGrid grid = RandomGrid(4);
  const GrayImage image = GridToImage(grid);
  const std::string pgm = GridToPgm(grid);
  EXPECT_EQ(pgm.substr(pgm.size() - image.pixels.size()),
            std::string(image.pixels.begin(), image.pixels.end()));
}

TEST_F(GridIoTest, ReadsYamlOfOtherPrograms) {
  for (const char* yaml :
       {"---\n# a map\nimage: \"map.pgm\"  # beside\nresolution: 5e-2\norigin: [-1.5,2.0,-0.0]\n"
        "negate: 0\noccupied_thresh: 0.65 \nfree_thresh: 0.25\r\n\n",
        "free_thresh: 0.196\nimage: map.pgm\nnegate: false\noccupied_thresh: 0.65\norigin:\n"
        "- -1.5\n- 2.0\n- 0.0\nresolution: 0.05\n",
        "%YAML 1.1\n---\n{\"image\": \"map.pgm\", 'mode': Trinary, resolution: 0.05, negate: no,\n"
        " origin: [-1.5, 2, 0], occupied_thresh: 0.65, free_thresh: 0.1, elevation: [1]}\n...\n"}) {
    Write(yaml, kPgm);
    const OccupancyGrid grid = ReadGrid(Yaml());
    EXPECT_EQ(grid.resolution_m, 0.05);
    EXPECT_EQ(grid.origin_in_map, Eigen::Vector2d(-1.5, 2));
    EXPECT_EQ(grid.cells, (std::vector<std::uint8_t>{kOccupiedCell, kFreeCell}));
    EXPECT_EQ(GridImagePath(Yaml()), folder_ / "map.pgm");
  }
  for (const char* yes : {"1", "true", "True", "yes"}) {
    Write(Replace(kYaml, "negate: 0", std::string("negate: ") + yes), kPgm);
    EXPECT_EQ(ReadGrid(Yaml()).cells, (std::vector<std::uint8_t>{kFreeCell, kOccupiedCell})) << yes;
  }
}

// Nav2 reads the first document and takes the first of two equal keys; here both are errors.
TEST_F(GridIoTest, RefusesBadYaml) {
  for (const char* key :
       {"image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"}) {
    ExpectError(Replace(kYaml, std::string(key) + ":", "other:"),
                kPgm,
                fmt::format("map.yaml:1: missing key '{}'", key));
  }
  ExpectError(Replace(kYaml, "0.05", "nan"), kPgm, "map.yaml:2: resolution is 'nan'");
  ExpectError(Replace(kYaml, "0.05", "0"), kPgm, "resolution");
  ExpectError(Replace(kYaml, "0.05", "1e-300"), kPgm, "resolution is 1e-300, not in");
  ExpectError(Replace(kYaml, "0.05", "1e300"), kPgm, "resolution is 1e300, not in");
  ExpectError(Replace(kYaml, "0.05", "0.05x"), kPgm, "resolution");
  ExpectError(Replace(kYaml, "2, 0]", "2, nan]"), kPgm, "map.yaml:3: origin is 'nan'");
  ExpectError(Replace(kYaml, "-1.5", ".inf"), kPgm, "origin");
  ExpectError(Replace(kYaml, "2, 0]", "2, .inf]"), kPgm, "origin");
  ExpectError(Replace(kYaml, "[-1.5, 2, 0]", "0"), kPgm, "map.yaml:3: origin is not a list");
  for (const char* origin :
       {"[1e9, 2, 0]", "[-1.5, -1e300, 0]", "[-1.5, 2, 180]", "[1, 2]", "[]"}) {
    ExpectError(Replace(kYaml, "[-1.5, 2, 0]", origin), kPgm, "the yaw in radians");
  }
  ExpectError(Replace(kYaml, "negate: 0", "negate: 2"), kPgm, "map.yaml:4: negate is '2'");
  ExpectError(Replace(kYaml, "0.65", "1.5"), kPgm, "map.yaml:5: occupied_thresh");
  ExpectError(Replace(kYaml, "0.196", "0.7"), kPgm, "map.yaml:6: free_thresh");
  ExpectError(Replace(kYaml, "trinary", "binary"), kPgm, "map.yaml:7: mode is 'binary'");
  ExpectError(kYaml + "negate: 0\n", kPgm, "twice");
  ExpectError(kYaml + "nonsense: [\n", kPgm, "not valid YAML");
  ExpectError(kYaml + "---\n" + kYaml, kPgm, "expected one YAML document");
  ExpectError(Replace(kYaml, "map.pgm", "absent.pgm"), kPgm, "absent.pgm");
  for (const char* image : {"''", "\"a\\0b\""}) {
    ExpectError(Replace(kYaml, "map.pgm", image), kPgm, "map.yaml:1: image is not the name");
  }
  ExpectError(Replace(kYaml, "map.pgm", "."), kPgm, "not a file");
}

TEST_F(GridIoTest, RefusesBadImage) {
  for (std::size_t length = 0; length < kPgm.size(); ++length) {
    Write(kYaml, kPgm.substr(0, length));
    EXPECT_THROW(ReadGrid(Yaml()), DataError) << length;
  }
  ExpectError(kYaml, kPgm.substr(0, kPgm.size() - 1), "truncated");
  ExpectError(kYaml, kPgm + "x", "too long");
  ExpectError(kYaml, Replace(kPgm, "P5", "P7"), "no picture of a known format");
  ExpectError(kYaml, Replace(kPgm, "255", "65535"), "map.pgm");  // two bytes a pixel
  ExpectError(kYaml, Replace(kPgm, "255", "0"), "largest value");
  ExpectError(kYaml, Replace(kPgm, "255", "65536"), "largest value");
  ExpectError(kYaml, Replace(kPgm, "2 1", "-2 1"), "width");
  ExpectError(kYaml, Replace(kPgm, "2 1", "2 0"), "height");
  ExpectError(kYaml, Replace(kPgm, "2 1", "9999999999 1"), "width");
  ExpectError(kYaml, Replace(kPgm, "2 1", "60000 1"), "60000 x 1 pixels");
  ExpectError(kYaml, Replace(kPgm, "2 1", "32768 32768"), "32768");
  ExpectError(kYaml, "P2\n2 1\n255\n0", "map.pgm");
  ExpectError(kYaml, "P2\n2 1\n255\n0 x", "map.pgm");
  ExpectError(kYaml, "P2\n2 1\n0\n0 0", "largest value");
}

}  // namespace nightmap::grid_io_test
