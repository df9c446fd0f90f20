// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/tile_texture_io.h"

#include "tests/test_data.h"

namespace nightmap::tile_texture_io_test {

TileMesh TwoTriangles() {
  TileMesh mesh;
  mesh.vertices.resize(4);
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  mesh.components = {{4, 0, 2, 1.0}};
  return mesh;
}

TileTexture OneWithAPage() {
  TileTexture texture;
  texture.pages = {std::string("jpeg\0one", 8), "two"};
  texture.charts = {{0, 1, 3, 1}, {0, TextureChart::kNoPage, 3, 1}};
  texture.vertices = {{0, {0, 0.25F}}, {1, {1, 0}}, {2, {0.5F, 1}}, {1}, {3}, {2}};
  texture.triangles = {{0, 1, 2}, {0, 1, 2}};
  return texture;
}

class TileTextureIoTest : public InFolder {
 protected:
  TileTexture Read(const TileTexture& texture, const TileMesh& mesh = TwoTriangles()) const {
    WriteTileTexture(folder_ / "tile.h5", texture, "texel_m = 0.005\n");
    return ReadTileTexture(folder_ / "tile.h5", mesh);
  }
};

TEST_F(TileTextureIoTest, ReadsWhatWasWritten) {
  const TileTexture texture = OneWithAPage(), read = Read(texture);
  EXPECT_EQ(read.pages, texture.pages);
  EXPECT_EQ(read.triangles, texture.triangles);
  ASSERT_EQ(read.charts.size(), 2U);
  EXPECT_EQ(read.charts[0].page, 1);
  EXPECT_EQ(read.charts[1].page, TextureChart::kNoPage);
  ASSERT_EQ(read.vertices.size(), 6U);
  EXPECT_EQ(read.vertices[4].vertex, 3);
  EXPECT_EQ(read.vertices[2].uv, Eigen::Vector2f(0.5F, 1));
  EXPECT_TRUE(Read({}, {}).pages.empty());
}

TEST_F(TileTextureIoTest, RefusesNumbersThatDoNotFit) {
  const auto refused = [&](const char* field, const auto& damage) {
    TileTexture texture = OneWithAPage();
    damage(texture);
    NIGHTMAP_EXPECT_ERROR(DataError, Read(texture), field);
  };
  refused("chart", [](TileTexture& texture) { texture.charts[0].component = 1; });
  refused("chart", [](TileTexture& texture) { texture.charts[0].page = 2; });
  refused("chart", [](TileTexture& texture) { texture.charts[0].num_vertices = -3; });
  refused("chart", [](TileTexture& texture) { texture.charts[1].num_triangles = 2; });
  refused("vertex", [](TileTexture& texture) { texture.vertices[0].vertex = 4; });
  refused("vertex", [](TileTexture& texture) { texture.vertices.push_back({0}); });
  refused("uv", [](TileTexture& texture) { texture.vertices[0].uv.x() = 1.5F; });
  refused("triangle", [](TileTexture& texture) { texture.triangles[0][0] = 3; });
  TileMesh other = TwoTriangles();
  other.triangles.pop_back();
  NIGHTMAP_EXPECT_ERROR(DataError, Read(OneWithAPage(), other), "triangle");
}

}  // namespace nightmap::tile_texture_io_test
