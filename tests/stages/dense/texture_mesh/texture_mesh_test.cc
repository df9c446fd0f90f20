// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/texture_mesh.h"

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::texture_mesh_test {

constexpr int kNumX = 40, kNumY = 16;  // cells of 5 cm
constexpr double kCell_m = 0.05;
constexpr double kOccluder_m = 0.5;  // its height above the floor

// The colors of the floor: waves of 20 cm, so that a texel of 5 mm is up to 15 gray levels.
Eigen::Array3d FloorColor(double x_m, double y_m) {
  const double turn = 2 * M_PI / 0.2;
  return {128 + 100 * std::sin(turn * x_m), 128 + 100 * std::sin(turn * y_m), 90};
}

// The floor 0 <= x < 2, 0 <= y < 0.8, seen from above, or from below. It is one component.
TileMesh Floor(bool is_seen_from_above = true) {
  TileMesh mesh;
  for (int y = 0; y <= kNumY; ++y) {
    for (int x = 0; x <= kNumX; ++x) {
      const Eigen::Vector2d at = kCell_m * Eigen::Vector2d(x, y);
      const Eigen::Array3d rgb = FloorColor(at.x(), at.y()).round();
      MeshVertex& vertex = mesh.vertices.emplace_back();
      vertex.position_in_map = {static_cast<float>(at.x()), static_cast<float>(at.y()), 0};
      vertex.normal_in_map = {0, 0, is_seen_from_above ? 1.0F : -1.0F};
      for (int c = 0; c < 3; ++c) {
        vertex.rgb[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(rgb[c]);
      }
    }
  }
  for (int y = 0; y < kNumY; ++y) {
    for (int x = 0; x < kNumX; ++x) {
      const auto a = static_cast<std::uint32_t>(y * (kNumX + 1) + x);
      const std::uint32_t b = a + 1, c = a + kNumX + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  if (!is_seen_from_above) {
    for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  mesh.components = {{static_cast<std::uint32_t>(mesh.vertices.size()),
                      0,
                      static_cast<std::uint32_t>(mesh.triangles.size()),
                      kNumX * kNumY * kCell_m * kCell_m}};
  return mesh;
}

// Cameras 1 m above the floor that look down on it; one of them may be broken.
struct Scene {
  std::vector<double> cameras_x_m;
  double occluded_to_x_m = -10;  // the end of a red plate above the floor
  double brightness = 1;
  int unreadable = -1;  // frame_idx

  RgbdImages Render(const Keyframe& keyframe, const RgbdCamera& camera) const {
    if (keyframe.frame.frame_idx == unreadable) throw DataError("picture 0: truncated");
    RgbdImages images;
    images.color = {camera.color.width, camera.color.height, 3, {}};
    images.depth = {camera.color.width, camera.color.height, 1, {}};
    for (int y = 0; y < camera.color.height; ++y) {
      for (int x = 0; x < camera.color.width; ++x) {
        const Eigen::Vector3d ray =
            keyframe.map_from_camera.rotation * camera.color.BackProject({x, y}, 1);
        const Eigen::Vector3d& from = keyframe.map_from_camera.translation;
        const Eigen::Vector3d on_plate = from + (from.z() - kOccluder_m) * ray;
        const bool is_plate = on_plate.x() < occluded_to_x_m;
        const Eigen::Vector3d on_floor = from + from.z() * ray;
        const Eigen::Array3d rgb =
            is_plate ? Eigen::Array3d(255, 0, 0) : FloorColor(on_floor.x(), on_floor.y());
        for (int c = 0; c < 3; ++c) {
          images.color.pixels.push_back(
              static_cast<std::uint8_t>(std::floor(brightness * rgb[c] + 0.5)));
        }
        images.depth.pixels.push_back(
            static_cast<float>(is_plate ? from.z() - kOccluder_m : from.z()));
      }
    }
    return images;
  }

  KeyframeSource Source() const {
    RgbdCamera camera;
    camera.color = {320, 240, 240, 240, 159.5, 119.5, 0.1, -0.05, 0.001, -0.001, 0};
    KeyframeSource source;
    source.cameras = {camera};
    source.region.max_range_m = 4;
    for (const double x_m : cameras_x_m) {
      Keyframe& keyframe = source.keyframes.emplace_back();
      keyframe.keyframe_idx = static_cast<int>(source.keyframes.size()) * 3;
      keyframe.frame.frame_idx = static_cast<int>(source.keyframes.size()) - 1;
      keyframe.map_from_camera.rotation = {0, 1, 0, 0};
      keyframe.map_from_camera.translation = {x_m, 0.4, 1};
    }
    source.load = [*this, camera](const Keyframe& keyframe) { return Render(keyframe, camera); };
    Scene readable = *this;
    readable.unreadable = -1;
    source.load_depth = [readable, camera](const Keyframe& keyframe) {
      return readable.Render(keyframe, camera).depth;
    };
    return source;
  }
};

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
  // Of the mean of the four texels around.
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
  // What the plate hides from the one is seen by the other.
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
