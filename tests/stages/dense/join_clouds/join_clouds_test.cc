// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_clouds/write_joined_cloud.h"

#include "tests/dense/join_tiles.h"

namespace nightmap::join_clouds_test {

using Path = std::filesystem::path;

CloudPoint PointAt(float x_m) {
  CloudPoint point;
  point.position_in_map = {x_m, 0, 0};
  point.normal_in_map = {0, 0, 1};
  return point;
}

std::vector<float> ReadX_m(const Path& path) {
  std::vector<float> x_m;
  PlyReader reader(path);
  while (const auto point = reader.Next()) x_m.push_back(point->position_in_map.x());
  return x_m;
}

// Two tiles with two points each, made with voxels of 0.1 m.
class JoinCloudsTest : public testing::Test {
 protected:
  void SetUp() override {
    WritePly(Cloud(0), {PointAt(0.05F), PointAt(0.25F)});
    WritePly(Cloud(1), {PointAt(0.15F), PointAt(0.35F)});
    for (const int i : {0, 1}) {
      const Tile tile = TileOf({{{i - 1.0, 0}, {i + 0.0, 1}}, 0.5, 4.0}, 4);
      folder_.Write(TileFile(i).filename(), TileToJson(tile));
      WriteReport(i, "keyframe_stride = 2\nmax_depth_m = 3.5\nvoxel_size_m = 0.1\n");
    }
  }

  Path TileFile(int i) const { return folder_ / ("tile_" + std::to_string(i) + "_0.json"); }
  Path Cloud(int i) const { return folder_ / ("tile_" + std::to_string(i) + "_0.ply"); }
  Path ReportFile(int i) const { return folder_ / ("report_" + std::to_string(i) + "_0.json"); }

  void WriteReport(int i, const std::string& config, const std::vector<std::string>& skipped = {}) {
    const nlohmann::json report{{"config", config},
                                {"skipped", skipped},
                                {"num_held_out_rays", 100},
                                {"num_held_out_rays_agreeing", 80 + 10 * i},
                                {"num_held_out_rays_blocked", 1}};
    folder_.Write(ReportFile(i).filename(), report.dump());
  }

  // Exit code of the program; err_ has its log.
  int Join(JoinCloudsOptions options = {}, const std::vector<int>& tiles = {0, 1}) {
    std::vector<std::string> arguments;
    for (const int i : tiles) {
      arguments.insert(arguments.end(), {"--in", "tile=" + TileFile(i).string()});
      arguments.insert(arguments.end(), {"--in", "tile_cloud=" + Cloud(i).string()});
      arguments.insert(arguments.end(), {"--in", "tile_report=" + ReportFile(i).string()});
    }
    arguments.insert(arguments.end(), {"--out", "cloud=" + (folder_ / "cloud.ply").string()});
    arguments.insert(arguments.end(), {"--out", "report=" + (folder_ / "report.json").string()});
    const StageSpec spec{"join_clouds",
                         "test",
                         {{"tile", "", Arity::kMany},
                          {"tile_cloud", "", Arity::kMany},
                          {"tile_report", "", Arity::kMany}},
                         {{"cloud", ""}}};
    return RunProgram(spec, arguments, options, WriteJoinedCloud, &err_);
  }

  TemporaryFolder folder_;
  std::string err_;
};

TEST_F(JoinCloudsTest, PointsAreInOrderOfTheVoxelsOfTheTilesConfig) {
  ASSERT_EQ(Join(), 0) << err_;
  EXPECT_THAT(ReadX_m(folder_ / "cloud.ply"), testing::ElementsAre(0.05F, 0.15F, 0.25F, 0.35F));
  const auto report = nlohmann::json::parse(ReadFile(folder_ / "report.json"));
  EXPECT_EQ(report["num_tiles"], 2);
  EXPECT_EQ(report["num_keyframes"], 2);  // every second of four, both tiles list the same
  EXPECT_EQ(report["num_points"], 4);
  EXPECT_EQ(report["held_out_rays_agreeing_percent"], 85.0);
}

TEST_F(JoinCloudsTest, AnExportIsThereExactlyWhenAskedFor) {
  ASSERT_EQ(Join({.export_pcd = true}), 0) << err_;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "cloud.pcd"));
  ASSERT_EQ(Join(), 0) << err_;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "cloud.pcd"));
}

TEST_F(JoinCloudsTest, RemovesWhatIsOfOtherTiles) {
  ASSERT_EQ(Join({}, {1}), 0) << err_;
  EXPECT_FALSE(std::filesystem::exists(Cloud(0)));
  EXPECT_TRUE(std::filesystem::exists(Cloud(1)));
}

TEST_F(JoinCloudsTest, TilesOfDifferentConfigsAreRefused) {
  WriteReport(1, "keyframe_stride = 2\nmax_depth_m = 3.5\nvoxel_size_m = 0.2\n");
  EXPECT_EQ(Join(), 1);
  EXPECT_THAT(err_, testing::HasSubstr(ReportFile(1).string()));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "cloud.ply"));
}

TEST_F(JoinCloudsTest, NoPointInAnyTileIsAnErrorThatNamesTheRange) {
  for (const int i : {0, 1}) WritePly(Cloud(i), {});
  EXPECT_EQ(Join(), 1);
  EXPECT_THAT(err_, testing::HasSubstr("d.png: no depth within 3.5 m"));
  EXPECT_THAT(err_, testing::HasSubstr("point_cloud.max_depth_m"));
}

TEST_F(JoinCloudsTest, TooManyUnreadableKeyframesFail) {
  for (const int i : {0, 1}) {
    WriteReport(i, "keyframe_stride = 2\nmax_depth_m = 3.5\nvoxel_size_m = 0.1\n", {"d: cut"});
  }
  EXPECT_EQ(Join(), 1);  // 1 of 2
  EXPECT_THAT(err_, testing::HasSubstr("max_failed_ratio"));
  EXPECT_EQ(Join({.max_failed_ratio = 0.5}), 0) << err_;
}

}  // namespace nightmap::join_clouds_test
