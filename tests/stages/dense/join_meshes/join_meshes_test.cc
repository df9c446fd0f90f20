// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/join_meshes.h"

#include <cstring>

#include "pipeline/base/files.h"
#include "stages/dense/join_meshes/glb_io.h"
#include "stages/dense/join_meshes/write_joined_mesh.h"
#include "tests/dense/join_tiles.h"
#include "tests/stages/dense/join_meshes/two_squares.h"

namespace nightmap::join_meshes_test {

using Path = std::filesystem::path;

struct Collected {
  JoinedMesh joined;
  std::vector<MeshVertex> vertices;
  std::vector<Triangle> triangles;
};

Collected Join(const std::vector<TileMesh>& tiles, double min_component_m2) {
  Collected all;
  RunJoinMeshes({.min_component_m2 = min_component_m2},
                tiles.size(),
                [&](std::size_t tile) { return tiles[tile]; },
                {[&](const JoinedMesh& joined) { all.joined = joined; },
                 [&](const MeshVertex& vertex) { all.vertices.push_back(vertex); },
                 [&](const Triangle& triangle) { all.triangles.push_back(triangle); }});
  EXPECT_EQ(all.joined.size.num_vertices, all.vertices.size());
  EXPECT_EQ(all.joined.size.num_triangles, all.triangles.size());
  return all;
}

TEST(JoinMeshes, VerticesOnASeamBecomeOne) {
  const Collected all = Join(TwoSquares(), 0.01);
  EXPECT_EQ(all.vertices.size(), 6U);
  double area_m2 = 0;
  for (const auto& [a, b, c] : all.triangles) {
    const auto at = [&](std::uint32_t i) { return all.vertices[i].position_in_map; };
    const Eigen::Vector3f across = (at(b) - at(a)).cross(at(c) - at(a));
    EXPECT_GT(across.z(), 0);  // still seen from above
    area_m2 += across.z() / 2;
  }
  EXPECT_NEAR(area_m2, 2, 1e-6);
  EXPECT_EQ(all.joined.box_in_map.min(), Eigen::Vector3f(0, 0, 7));
  EXPECT_EQ(all.joined.box_in_map.max(), Eigen::Vector3f(2, 1, 7));
}

TEST(JoinMeshes, SmallComponentsAreDroppedByTheirAreaOverAllTiles) {
  EXPECT_EQ(Join(TwoSquares(), 0).joined.num_components, 2U);
  const Collected without = Join(TwoSquares(), 1.5);  // each square alone is smaller
  EXPECT_EQ(without.joined.num_components, 1U);
  EXPECT_EQ(without.joined.num_dropped_components, 1U);
  EXPECT_EQ(without.triangles.size(), 4U);
  NIGHTMAP_EXPECT_ERROR(DataError, Join(TwoSquares(), 3), "join_meshes.min_component_m2");
}

TEST(JoinMeshes, ASeamOfDroppedPartsLeavesNoVertices) {
  auto tiles = TwoSquares();
  std::swap(tiles[0].components[0].area_m2, tiles[0].components[1].area_m2);
  tiles[1].components[0].area_m2 = 0.25;
  const Collected all = Join(tiles, 0.5);
  EXPECT_EQ(all.vertices.size(), 3U);
  EXPECT_EQ(all.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

template <typename Value>
Value At(const std::string& bytes, std::size_t offset) {
  Value value;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

class JoinMeshesFilesTest : public InFolder {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(textures_);
    const auto meshes = TwoSquares();
    for (const int i : {0, 1}) {
      WriteTileMesh(File("tile", i, ".ply"), meshes[static_cast<std::size_t>(i)]);
      WriteTileTexture(Texture(i), TwoTextures()[static_cast<std::size_t>(i)], "");
      folder_.Write(File("texture_report", i, ".json").filename(), R"({"config": ""})");
      const Tile tile = TileOf({{{i + 0.0, 0}, {i + 1.0, 1}}, 0.5, 4.0}, 1);
      folder_.Write(File("tile", i, ".json").filename(), TileToJson(tile));
      WriteReport(i, "cell_voxels = 2.0\n");
    }
  }

  Path File(const std::string& kind, int i, const std::string& extension) const {
    return folder_ / (kind + "_" + std::to_string(i) + "_0" + extension);
  }

  Path Texture(int i) const { return textures_ / ("tile_" + std::to_string(i) + "_0.h5"); }

  void WriteReport(int i, const std::string& config) const {
    folder_.Write(File("report", i, ".json").filename(), nlohmann::json{{"config", config}}.dump());
  }

  // Exit code of the program; err_ has its log.
  int JoinFiles(const std::vector<int>& tiles = {0, 1}) {
    std::vector<std::string> arguments;
    const auto add = [&](const char* option, const std::string& port, const Path& path) {
      arguments.insert(arguments.end(), {option, port + "=" + path.string()});
    };
    for (const int i : tiles) {
      add("--in", "tile", File("tile", i, ".json"));
      add("--in", "tile_mesh", File("tile", i, ".ply"));
      add("--in", "tile_report", File("report", i, ".json"));
      add("--in", "tile_texture", Texture(i));
      add("--in", "texture_report", File("texture_report", i, ".json"));
    }
    for (const char* port : {"mesh", "glb", "textured", "report"})
      add("--out", port, folder_ / port);
    const StageSpec spec{"join_meshes",
                         "test",
                         {{"tile", "", Arity::kMany},
                          {"tile_mesh", "", Arity::kMany},
                          {"tile_report", "", Arity::kMany},
                          {"tile_texture", "", Arity::kMany},
                          {"texture_report", "", Arity::kMany}},
                         {{"mesh", ""}, {"glb", ""}, {"textured", ""}}};
    return RunProgram(spec, arguments, JoinMeshesOptions{}, WriteJoinedMesh, &err_);
  }

  const Path textures_ = folder_ / "textures";  // the folder of another job
  std::string err_;
};

TEST_F(JoinMeshesFilesTest, TheGlbIsWhatItsDescriptionSays) {
  ASSERT_EQ(JoinFiles(), 0) << err_;
  const std::string glb = ReadFile(folder_ / "glb");
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(At<std::uint32_t>(glb, 4), 2U);
  EXPECT_EQ(At<std::uint32_t>(glb, 8), glb.size());
  const std::size_t json_bytes = At<std::uint32_t>(glb, 12);
  EXPECT_EQ(json_bytes % 4, 0U);
  EXPECT_EQ(glb.substr(16, 4), "JSON");
  const auto json = nlohmann::json::parse(glb.substr(20, json_bytes));
  const std::size_t begin = 20 + json_bytes + 8;
  EXPECT_EQ(At<std::uint32_t>(glb, begin - 8), glb.size() - begin);
  EXPECT_EQ(glb.substr(begin - 4, 4), std::string("BIN\0", 4));
  EXPECT_EQ(json["buffers"][0]["byteLength"], glb.size() - begin);
  EXPECT_EQ(json["accessors"][0]["count"], 6);
  EXPECT_EQ(json["accessors"][3]["count"], 12);
  // (x, y, 7) of the map
  EXPECT_EQ(json["accessors"][0]["min"], (nlohmann::json{0.0, 7.0, -1.0}));
  EXPECT_EQ(json["accessors"][0]["max"], (nlohmann::json{2.0, 7.0, 0.0}));
  const std::size_t stride = json["bufferViews"][0]["byteStride"];
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(At<float>(glb, begin + i * stride + 4), 7);
    EXPECT_EQ(At<float>(glb, begin + i * stride + 16), 1);  // the normal is up
  }
  const auto color = At<std::array<std::uint16_t, 4>>(glb, begin + 24);
  EXPECT_THAT(color, testing::ElementsAre(65535, 0, 14146, 65535));  // sRGB 128 is 0.2158605 linear
}

TEST_F(JoinMeshesFilesTest, RemovesWhatIsOfOtherTiles) {
  ASSERT_EQ(JoinFiles({1}), 0) << err_;
  EXPECT_FALSE(std::filesystem::exists(File("tile", 0, ".ply")));
  EXPECT_FALSE(std::filesystem::exists(textures_ / "tile_0_0.h5"));
  EXPECT_TRUE(std::filesystem::exists(textures_ / "tile_1_0.h5"));
  EXPECT_TRUE(std::filesystem::exists(File("tile", 1, ".ply")));
}

TEST_F(JoinMeshesFilesTest, DamagedTilesLeaveNoFiles) {
  std::string bytes = ReadFile(File("tile", 1, ".ply"));
  bytes.back() = '\x7F';
  WriteFile(File("tile", 1, ".ply"), bytes);
  EXPECT_EQ(JoinFiles(), 1);
  EXPECT_THAT(err_, testing::HasSubstr(File("tile", 1, ".ply").string()));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "mesh"));
}

TEST_F(JoinMeshesFilesTest, TilesOfDifferentConfigsAreRefused) {
  WriteReport(1, "cell_voxels = 3.0\n");
  EXPECT_EQ(JoinFiles(), 1);
  EXPECT_THAT(err_, testing::HasSubstr(File("report", 1, ".json").string()));
}

TEST_F(JoinMeshesFilesTest, ATextureOfAnotherMeshIsRefused) {
  WriteTileTexture(Texture(1), TwoTextures()[0], "");
  EXPECT_EQ(JoinFiles(), 1);
  EXPECT_THAT(err_, testing::HasSubstr(Texture(1).string()));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "mesh"));
}

TEST_F(JoinMeshesFilesTest, AMeshBeyondFourGibibytesIsRefusedWithARemedy) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        GlbWriter(folder_ / "glb", {90'000'000, 180'000'000}, {}),
                        "4 GiB",
                        "mesh.cell_voxels");
}

}  // namespace nightmap::join_meshes_test
