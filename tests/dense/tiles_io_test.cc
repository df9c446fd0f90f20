// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/tiles_io.h"

#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "pipeline/dense/tile_results.h"
#include "tests/test_data.h"

namespace nightmap::tiles_io_test {

class TilesIoTest : public testing::Test {
 protected:
  // The file with one text replaced is refused, and the message names it.
  void ExpectRefused(const std::string& from, const std::string& to, const std::string& part) {
    std::string text = TileToJson(SomeTile());
    ASSERT_NE(text.find(from), std::string::npos) << from;
    WriteFile(path_, text.replace(text.find(from), from.size(), to));
    NIGHTMAP_EXPECT_ERROR(DataError, ReadTile(path_), part, path_.string());
  }

  static constexpr const char* kConfig = "keyframe_stride = 1\n";

  // The report of a tile made with a config; `more` has other fields.
  static std::string Report(const std::string& config, const std::string& more = {}) {
    return "{\"config\": " + nlohmann::json(config).dump() + (more.empty() ? "" : ", ") + more +
           "}";
  }

  static Tile SomeTile() {
    Tile tile;
    tile.region = {{{-36.1, 12.3}, {-12.1, 36.3}}, 0.5, 4.0};
    for (int i = 0; i < 20; ++i) {
      Random random(3, static_cast<std::uint64_t>(i));
      Keyframe keyframe;
      keyframe.keyframe_idx = 3 * i;
      keyframe.frame = {
          7 * i, 1305031102175304000 + i, i % 2, 1, {"a, \"b\"/c.jpg", "12"}, {"d.png", "ef"}, {}};
      if (i == 5) keyframe.frame.others["label"] = {"l.png", "34"};
      keyframe.map_from_camera.rotation = Eigen::AngleAxisd(
          random.Uniform(-3, 3), Eigen::Vector3d(1, random.Uniform(-1, 1), 2).normalized());
      keyframe.map_from_camera.translation = {
          random.Uniform(-40, 40), random.Uniform(-9, 9), 1.0 / 3};
      tile.keyframes.push_back(keyframe);
    }
    return tile;
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "tile_-1_2.json";
};

TEST_F(TilesIoTest, WhatIsWrittenIsReadToTheLastBit) {
  const Tile written = SomeTile();
  WriteFile(path_, TileToJson(written));
  const Tile read = ReadTile(path_);
  EXPECT_EQ(read.region.inside.min_m, written.region.inside.min_m);
  EXPECT_EQ(read.region.inside.max_m, written.region.inside.max_m);
  EXPECT_EQ(read.region.overlap_m, written.region.overlap_m);
  EXPECT_EQ(read.region.max_range_m, written.region.max_range_m);
  ASSERT_EQ(read.keyframes.size(), written.keyframes.size());
  for (std::size_t i = 0; i < read.keyframes.size(); ++i) {
    const Keyframe &a = read.keyframes[i], &b = written.keyframes[i];
    EXPECT_EQ(a.keyframe_idx, b.keyframe_idx);
    EXPECT_EQ(a.map_from_camera.Matrix(), b.map_from_camera.Matrix());
    EXPECT_EQ(FramesToCsv({a.frame}), FramesToCsv({b.frame}));
  }
  EXPECT_EQ(TileToJson(read), TileToJson(written));
}

TEST_F(TilesIoTest, EveryTruncationIsRefused) {
  const std::string text = TileToJson(SomeTile());
  for (std::size_t size = 0; size + 2 < text.size(); size += 41) {
    WriteFile(path_, text.substr(0, size));
    EXPECT_THROW(ReadTile(path_), DataError) << size << " of " << text.size() << " bytes";
  }
}

TEST_F(TilesIoTest, MistakesAreRefused) {
  ExpectRefused("nightmap tile", "nightmap stile", "format");
  ExpectRefused("\"version\": 2", "\"version\": 3", "newer");
  ExpectRefused("\"channels\":{", "\"canals\":{", "channels");
  ExpectRefused("\"color\":{", "\"colour\":{", "color_path is empty");
  ExpectRefused("\"hash\":\"34\"", "\"hash\":\"\"", "label_hash is empty");
  ExpectRefused("\"hash\":\"34\"", "\"hash\":34", "string");
  ExpectRefused("\"min_x_m\": -36.1", "\"min_x_m\": -12.1", "no extent");
  ExpectRefused("\"min_x_m\": -36.1", "\"min_x_m\": null", "number");
  ExpectRefused("\"max_range_m\": 4.0", "\"max_range_m\": 0", "no extent");
  ExpectRefused("\"keyframe_idx\":57", "\"keyframe_idx\":54", "must increase");
  for (const std::string wrong : {"-1", "4294967297", "18446744073709551615", "1e300", "0.5"}) {
    ExpectRefused("\"camera_idx\":1", "\"camera_idx\":" + wrong, "camera_idx is");
  }
  ExpectRefused("\"map_from_camera\":[", "\"map_from_camera\":[1.0,", "8 numbers");
  Tile tile = SomeTile();
  tile.keyframes[2].map_from_camera.rotation.coeffs() *= 1.01;
  WriteFile(path_, TileToJson(tile));
  EXPECT_THROW(ReadTile(path_), DataError);
}

TEST_F(TilesIoTest, NamesThatAreNoTextAreRefusedByName) {
  Tile tile = SomeTile();
  tile.keyframes[3].frame.color.path = "caf\xE9.jpg";
  EXPECT_THROW(TileToJson(tile), DataError);
}

TEST_F(TilesIoTest, ResultsCountKeyframesAndReasonsOnce) {
  Tile tile = SomeTile();
  WriteFile(folder_ / "a.json", TileToJson(tile));
  tile.keyframes.erase(tile.keyframes.begin(), tile.keyframes.begin() + 5);
  tile.keyframes.back().keyframe_idx = 1000;
  WriteFile(folder_ / "b.json", TileToJson(tile));
  WriteFile(folder_ / "1.json", Report(kConfig, R"("skipped": ["x: truncated", "y: truncated"])"));
  WriteFile(folder_ / "2.json", Report(kConfig, R"("skipped": ["x: truncated"])"));
  WriteFile(folder_ / "3.json", Report(kConfig));
  const std::vector<std::filesystem::path> tiles = {folder_ / "a.json", folder_ / "b.json"};
  const auto results =
      ReadTileResults(tiles, {folder_ / "1.json", folder_ / "2.json", folder_ / "3.json"});
  EXPECT_EQ(results.num_keyframes, 21U);
  EXPECT_EQ(results.skipped.Count(), 2U);
  EXPECT_EQ(results.first_depth_path, "d.png");
  WriteFile(folder_ / "1.json", Report("keyframe_stride = 6\n"));
  // The keyframes 0, 6 ... of 0, 3 ... 57
  EXPECT_EQ(ReadTileResults(tiles, {folder_ / "1.json"}).num_keyframes, 10U);
  WriteFile(folder_ / "2.json", R"({"skipped": ["x: trun)");
  EXPECT_THROW(ReadTileResults(tiles, {folder_ / "2.json"}), DataError);
}

TEST_F(TilesIoTest, TheConfigOfTilesIsThatOfTheirReports) {
  const std::string report = Report("voxel_size_m = 0.03\nkeyframe_stride = 2\n");
  const TileConfig config({folder_.Write("1.json", report), folder_.Write("2.json", report)});
  EXPECT_EQ(config.Number("voxel_size_m", Range(0.002, 1)), 0.03);
  EXPECT_EQ(config.Integer("keyframe_stride", Range(1, 1000)), 2);
  EXPECT_THROW(config.Number("voxel_size_m", Range(0.04, 1)), DataError);
  EXPECT_THROW(config.Number("max_depth_m", Range(0, 100)), DataError);
  EXPECT_THROW(config.Integer("voxel_size_m", Range(0, 1)), DataError);
}

TEST_F(TilesIoTest, TilesOfDifferentConfigsAreRefused) {
  const std::vector<std::filesystem::path> reports = {folder_ / "1.json", folder_ / "2.json"};
  WriteFile(reports[0], Report(kConfig));
  for (const std::string& other :
       {Report("keyframe_stride = 2\n"), std::string(R"({"num_skipped": 0})"), std::string("{")}) {
    WriteFile(reports[1], other);
    NIGHTMAP_EXPECT_ERROR(DataError, TileConfig(reports), reports[1].string(), "run make");
  }
}

TEST_F(TilesIoTest, AConfigThatHasNoSuchNumberIsRefused) {
  for (const char* damaged : {"",
                              "keyframe_stride =",
                              "keyframe_stride = \"1\"\n",
                              "keyframe_stride = 1.5\n",
                              "keyframe_stride = nan\n",
                              "keyframe_stride = 0\n",
                              "keyframe_stride = 3000000000\n"}) {
    const auto report = folder_.Write("1.json", Report(damaged));
    NIGHTMAP_EXPECT_ERROR(DataError,
                          TileConfig({report}).Integer("keyframe_stride", Range(1, 1000)),
                          report.string(),
                          "keyframe_stride");
  }
}

TEST_F(TilesIoTest, CountsOfReportsAreAddedAndMustBeThere) {
  const std::vector reports = {folder_.Write("1.json", R"({"num_rays": 5})"),
                               folder_.Write("2.json", R"({"num_rays": 70})")};
  EXPECT_EQ(SumOfReports(reports, "num_rays"), 75U);
  for (const char* damaged :
       {R"({"num": 5})", R"({"num_rays": -5})", R"({"num_rays": "5"})", R"({"n)"}) {
    WriteFile(folder_ / "2.json", damaged);
    NIGHTMAP_EXPECT_ERROR(DataError,
                          SumOfReports(reports, "num_rays"),
                          reports[1].string(),
                          "delete it and run make");
  }
}

TEST_F(TilesIoTest, RemovesWhatIsOfOtherTilesAndNothingElse) {
  const std::vector<std::string> stay = {"tile_0_0.ply",
                                         "tile_-1_2.json",
                                         "report_0_0.json",
                                         "places_0_0.csv",
                                         "report.json",
                                         "tiles.txt",
                                         "cloud.ply",
                                         "tile_5.json",
                                         "tile_1_1_1.json"};
  const std::vector<std::string> go = {
      "tile_-1_-1.ply", "tile_10_0.json", "report_0_1.json", "receipt_0_1.json", "places_0_1.csv"};
  for (const auto& name : stay) WriteFile(folder_ / name, "x");
  for (const auto& name : go) WriteFile(folder_ / name, "x");
  RemoveOtherTiles(folder_.Path(), {"elsewhere/tile_0_0.json", "tile_-1_2.json"});
  for (const auto& name : stay) EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
  for (const auto& name : go) EXPECT_FALSE(std::filesystem::exists(folder_ / name)) << name;
}

}  // namespace nightmap::tiles_io_test
