// SPDX-License-Identifier: Apache-2.0
// Pictures on the mesh of a tile: pages of texture, and where on them its triangles lie.
//
// HDF5, for P pages, C charts, V vertices and T triangles:
//   page_offset  int64[P + 1]   where each page begins in page_jpeg
//   page_jpeg    uint8[...]     JPEG files, one after the other
//   chart        int32[C x 4]   component of the mesh, page or -1, number of vertices and triangles
//   vertex       int32[V]       index in the mesh of the tile
//   uv           float[V x 2]   0 .. 1 from the top left corner of the page; 0 without a page
//   triangle     int32[T x 3]   vertices, from the first of the chart
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/dense/mesh_io.h"

namespace nightmap {

// Triangles with one picture. Vertices and triangles follow those of the chart before it.
struct TextureChart {
  static constexpr std::int32_t kNoPage = -1;  // triangles that keep the colors of their vertices
  std::int32_t component = 0;                  // of the mesh of the tile
  std::int32_t page = kNoPage;
  std::int32_t num_vertices = 0;
  std::int32_t num_triangles = 0;
};

struct TextureVertex {
  std::int32_t vertex = 0;  // in the mesh of the tile
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();
};

// Each triangle of the mesh of the tile is in one chart.
struct TileTexture {
  std::vector<std::string> pages;  // JPEG files
  std::vector<TextureChart> charts;
  std::vector<TextureVertex> vertices;
  std::vector<Triangle> triangles;  // of vertices counted from the first of the chart
};

// Equal textures and configs give equal bytes.
void WriteTileTexture(const std::filesystem::path& path,
                      const TileTexture& texture,
                      const std::string& config);
// Throws DataError naming file and field on numbers that do not fit each other or `mesh`, the mesh
// of the tile.
TileTexture ReadTileTexture(const std::filesystem::path& path, const TileMesh& mesh);

}  // namespace nightmap
