// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_octrees/join_octrees.h"

#include "pipeline/dense/octree_io.h"
#include "tests/dense/join_tiles.h"

namespace nightmap::join_octrees_test {

using Path = std::filesystem::path;

constexpr const char* kConfig = "keyframe_stride = 3\n";

// One tile of seven keyframes with an octree of one voxel.
class JoinOctreesTest : public testing::Test {
 protected:
  void SetUp() override {
    const Tile tile = TileOf({{{0, 0}, {1, 1}}, 0.5, 4.0}, 7);
    folder_.Write("tile_0_0.json", TileToJson(tile));
    WriteReport(kConfig);
    WriteTree(2.0F);
  }

  void WriteTree(float log_odds) {
    OccupancyTree tree;
    tree.resolution_m = 0.1;
    OccupancyVoxel voxel;
    voxel.centre_in_map = {0.05, 0.05, 0.05};
    voxel.size_m = 0.1;
    voxel.log_odds = log_odds;
    tree.leaves = {voxel};
    WriteOctree(folder_ / "tile_0_0.ot", tree);
  }

  void WriteReport(const std::string& config, const std::vector<std::string>& skipped = {}) {
    folder_.Write("report_0_0.json",
                  nlohmann::json{{"config", config}, {"skipped", skipped}}.dump());
  }

  // Exit code of the program; err_ has its log.
  int Join(JoinOctreesOptions options = {}) {
    std::vector<std::string> arguments;
    const auto add = [&](const char* flag, const std::string& name, const char* file) {
      arguments.insert(arguments.end(), {flag, name + "=" + (folder_ / file).string()});
    };
    add("--in", "tile", "tile_0_0.json");
    add("--in", "tile_ot", "tile_0_0.ot");
    add("--in", "tile_report", "report_0_0.json");
    add("--out", "ot", "map.ot");
    add("--out", "bt", "map.bt");
    add("--out", "report", "report.json");
    const StageSpec spec{"join_octrees",
                         "test",
                         {{"tile", "", Arity::kMany},
                          {"tile_ot", "", Arity::kMany},
                          {"tile_report", "", Arity::kMany}},
                         {{"ot", ""}, {"bt", ""}}};
    return RunProgram(spec, arguments, options, JoinOctreeFiles, &err_);
  }

  TemporaryFolder folder_;
  std::string err_;
};

TEST_F(JoinOctreesTest, JoinsAndCountsTheKeyframesOfTheTilesStride) {
  folder_.Write("tile_7_7.ot", "of a tile that is no more");
  ASSERT_EQ(Join(), 0) << err_;
  EXPECT_EQ(ReadBytes(folder_ / "map.ot"), ReadBytes(folder_ / "tile_0_0.ot"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tile_7_7.ot"));
  const auto report = nlohmann::json::parse(ReadFile(folder_ / "report.json"));
  EXPECT_EQ(report["num_keyframes"], 3);  // 0, 3 and 6
  EXPECT_EQ(report["num_occupied_voxels"], 1);
}

TEST_F(JoinOctreesTest, NothingOccupiedIsAnError) {
  WriteTree(-0.4F);
  EXPECT_EQ(Join(), 1);
  EXPECT_THAT(err_, testing::HasSubstr("raise octree.max_range_m"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "map.ot"));
}

TEST_F(JoinOctreesTest, AReportWithoutTheConfigIsRefusedByName) {
  WriteReport("resolution_m = 0.1\n");
  EXPECT_EQ(Join(), 1);
  EXPECT_THAT(err_, testing::HasSubstr("report_0_0.json: its config has no keyframe_stride"));
}

TEST_F(JoinOctreesTest, TooManyUnreadableKeyframesFail) {
  WriteReport(kConfig, {"d: cut"});
  EXPECT_EQ(Join(), 1);  // 1 of 3
  EXPECT_THAT(err_, testing::HasSubstr("max_failed_ratio"));
  EXPECT_EQ(Join({.max_failed_ratio = 0.4}), 0) << err_;
}

}  // namespace nightmap::join_octrees_test
