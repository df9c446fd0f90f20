// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/texture_mesh.h"

#include <cmath>

#include "pipeline/base/files.h"
#include "tests/stages/dense/texture_mesh/colored_floor.h"
#include "tests/test_data.h"

namespace nightmap::texture_mesh_test {

class TextureMeshTest : public InFolder {
 protected:
  TextureMeshResult Make(const Scene& scene, const TileMesh& mesh, int num_threads = 2) const {
    return RunTextureMesh(options_, mesh, scene.Source(), NoProgress(), num_threads);
  }

  std::vector<ColorImage> Pages(const TileTexture& texture) const {
    std::vector<ColorImage> pages;
    for (const std::string& page : texture.pages) {
      WriteFile(folder_ / "page.jpg", page);
      pages.push_back(ReadColorImage(folder_ / "page.jpg"));
    }
    return pages;
  }

  // The largest difference between the page and the floor at the middle of textured triangles. Each
  // triangle must be in one chart.
  double LargestError(const TileMesh& mesh, const TileTexture& texture) const {
    const auto pages = Pages(texture);
    EXPECT_EQ(texture.triangles.size(), mesh.triangles.size());
    double error = 0, area_m2 = 0;
    std::size_t vertex = 0, triangle = 0;
    for (const TextureChart& chart : texture.charts) {
      for (int i = 0; i < chart.num_triangles; ++i, ++triangle) {
        Eigen::Vector2d uv(0, 0);
        std::array<Eigen::Vector3f, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
          const TextureVertex& at = texture.vertices[vertex + texture.triangles[triangle][k]];
          corners[k] = mesh.vertices[static_cast<std::size_t>(at.vertex)].position_in_map;
          uv += at.uv.cast<double>() / 3;
        }
        area_m2 += (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() / 2;
        if (chart.page == TextureChart::kNoPage) continue;
        const ColorImage& page = pages[static_cast<std::size_t>(chart.page)];
        const Eigen::Vector3f middle = (corners[0] + corners[1] + corners[2]) / 3;
        error = std::max(error, ErrorAt(page, uv, middle));
      }
      vertex += static_cast<std::size_t>(chart.num_vertices);
    }
    EXPECT_NEAR(area_m2, kNumX * kNumY * kCell_m * kCell_m, 1e-4);
    return error;
  }

  TextureMeshOptions options_;

 private:
  // Compares the mean of the four texels around.
  static double ErrorAt(const ColorImage& page,
                        const Eigen::Vector2d& uv,
                        const Eigen::Vector3f& on_floor) {
    const double x = uv.x() * page.width - 0.5, y = uv.y() * page.height - 0.5;
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const double right = x - x0, low = y - y0;
    const Eigen::Array3d wanted = FloorColor(on_floor.x(), on_floor.y());
    double error = 0;
    for (int c = 0; c < 3; ++c) {
      const double found =
          (1 - low) * ((1 - right) * page.At(x0, y0, c) + right * page.At(x0 + 1, y0, c)) +
          low * ((1 - right) * page.At(x0, y0 + 1, c) + right * page.At(x0 + 1, y0 + 1, c));
      error = std::max(error, std::abs(found - wanted[c]));
    }
    return error;
  }
};

TEST_F(TextureMeshTest, TexelsLieWhereTheFloorHasTheirColor) {
  const TileMesh mesh = Floor();
  const auto result = Make({.cameras_x_m = {0.5, 1.5}}, mesh);
  EXPECT_EQ(result.num_textured_triangles, mesh.triangles.size());
  EXPECT_EQ(result.num_views, 2U);
  EXPECT_EQ(result.num_textured_charts, 2U);          // neighbours have one view
  EXPECT_LT(LargestError(mesh, result.texture), 10);  // 15 are a texel
}

TEST_F(TextureMeshTest, TexelsAreNotFinerThanAskedFor) {
  options_.texel_m = 0.02;
  const auto coarse = Make({.cameras_x_m = {1}}, Floor());
  options_.texel_m = 0.01;
  const auto fine = Make({.cameras_x_m = {1}}, Floor());
  const ColorImage small = Pages(coarse.texture)[0], large = Pages(fine.texture)[0];
  EXPECT_NEAR(small.width - 5, (large.width - 5) / 2.0, 2);  // less the gutter
  EXPECT_NEAR(small.height - 5, (large.height - 5) / 2.0, 2);
}

TEST_F(TextureMeshTest, ChartsFitTheirPage) {
  options_.page_px = 256;
  options_.texel_m = 0.001;
  const TileMesh mesh = Floor();
  const auto result = Make({.cameras_x_m = {0.5, 1.5}}, mesh);
  for (const ColorImage& page : Pages(result.texture)) {
    EXPECT_LE(page.width, 256);
    EXPECT_LE(page.height, 256);
  }
  EXPECT_LT(LargestError(mesh, result.texture), 10);
}

TEST_F(TextureMeshTest, WhatIsBehindAnObstacleDoesNotGetItsColor) {
  const TileMesh mesh = Floor();
  const auto result = Make({.cameras_x_m = {0.8}, .occluded_to_x_m = 0.7}, mesh);
  EXPECT_GT(result.num_textured_triangles, 300U);
  EXPECT_LT(LargestError(mesh, result.texture), 10);
  // The second camera sees what the plate hides from the first.
  const auto both = Make({.cameras_x_m = {0.8, 1.4}, .occluded_to_x_m = 0.7}, mesh);
  EXPECT_GT(both.num_textured_triangles, result.num_textured_triangles);
  EXPECT_LT(LargestError(mesh, both.texture), 10);
}

TEST_F(TextureMeshTest, TrianglesThatNoKeyframeSeesHaveNoPage) {
  const TileMesh mesh = Floor(false);
  const auto result = Make({.cameras_x_m = {0.5, 1.5}}, mesh);
  EXPECT_EQ(result.num_textured_triangles, 0U);
  EXPECT_TRUE(result.texture.pages.empty());
  ASSERT_EQ(result.texture.charts.size(), 1U);
  EXPECT_EQ(result.texture.charts[0].page, TextureChart::kNoPage);
  EXPECT_EQ(LargestError(mesh, result.texture), 0);
}

TEST_F(TextureMeshTest, DarkPicturesGetTheBrightnessOfTheMesh) {
  const TileMesh mesh = Floor();
  const auto result = Make({.cameras_x_m = {0.5, 1.5}, .brightness = 0.8}, mesh);
  EXPECT_LT(LargestError(mesh, result.texture), 12);
}

TEST_F(TextureMeshTest, TrianglesOfAnUnreadablePictureKeepTheirVertexColors) {
  const TileMesh mesh = Floor();
  const auto result = Make({.cameras_x_m = {0.5, 1.5}, .unreadable = 0}, mesh);
  EXPECT_THAT(result.skipped, testing::ElementsAre(testing::HasSubstr("truncated")));
  EXPECT_GT(result.num_textured_triangles, mesh.triangles.size() / 3);
  EXPECT_LT(result.num_textured_triangles, 2 * mesh.triangles.size() / 3);
  EXPECT_LT(LargestError(mesh, result.texture), 10);
}

TEST_F(TextureMeshTest, BytesDoNotDependOnThreads) {
  const Scene scene{.cameras_x_m = {0.4, 0.7, 1.0, 1.3, 1.6}, .occluded_to_x_m = 0.6};
  for (const int num_threads : {1, 3}) {
    const auto result = Make(scene, Floor(), num_threads);
    WriteTileTexture(folder_ / std::to_string(num_threads), result.texture, "");
  }
  EXPECT_EQ(ReadFile(folder_ / "1"), ReadFile(folder_ / "3"));
}

TEST_F(TextureMeshTest, ATileWithoutSurfaceHasNoTexture) {
  const auto result = Make({.cameras_x_m = {0.5}}, {});
  EXPECT_TRUE(result.texture.pages.empty());
  EXPECT_TRUE(result.texture.charts.empty());
}

}  // namespace nightmap::texture_mesh_test
