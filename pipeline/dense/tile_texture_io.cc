// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/tile_texture_io.h"

#include <algorithm>

#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kTextureFormat[] = "nightmap tile texture";
constexpr int kTextureVersion = 1;

void WritePages(const std::vector<std::string>& pages, Hdf5Writer* file) {
  std::vector<std::int64_t> offsets = {0};
  std::vector<std::uint8_t> bytes;
  for (const std::string& page : pages) {
    bytes.insert(bytes.end(), page.begin(), page.end());
    offsets.push_back(static_cast<std::int64_t>(bytes.size()));
  }
  file->WriteList("page_offset", offsets);
  file->WriteList("page_jpeg", bytes);
}

std::vector<std::string> ReadPages(const Hdf5Reader& file) {
  const auto bytes = file.ReadList<std::uint8_t>("page_jpeg");
  const auto offsets = file.ReadOffsets("page_offset", std::nullopt, bytes.size());
  std::vector<std::string> pages;
  for (std::size_t i = 0; i + 1 < offsets.size(); ++i) {
    pages.emplace_back(bytes.begin() + static_cast<std::ptrdiff_t>(offsets[i]),
                       bytes.begin() + static_cast<std::ptrdiff_t>(offsets[i + 1]));
  }
  return pages;
}

bool IsIndexOf(std::int64_t index, std::size_t size) {
  return index >= 0 && index < static_cast<std::int64_t>(size);
}

void CheckCharts(const Hdf5Reader& file, const TileTexture& texture, const TileMesh& mesh) {
  std::size_t vertex = 0, triangle = 0;
  for (const TextureChart& chart : texture.charts) {
    file.Demand(IsIndexOf(chart.component, mesh.components.size()), "chart");
    file.Demand(chart.page == TextureChart::kNoPage || IsIndexOf(chart.page, texture.pages.size()),
                "chart");
    file.Demand(chart.num_vertices >= 0 && chart.num_triangles >= 0, "chart");
    vertex += static_cast<std::size_t>(chart.num_vertices);
    const std::size_t end = triangle + static_cast<std::size_t>(chart.num_triangles);
    file.Demand(vertex <= texture.vertices.size() && end <= texture.triangles.size(), "chart");
    for (; triangle < end; ++triangle) {
      for (const std::uint32_t corner : texture.triangles[triangle]) {
        file.Demand(corner < static_cast<std::uint32_t>(chart.num_vertices), "triangle");
      }
    }
  }
  file.Demand(vertex == texture.vertices.size(), "vertex");
  file.Demand(triangle == texture.triangles.size() && triangle == mesh.triangles.size(),
              "triangle",
              "has not as many triangles as the mesh of the tile");
}

}  // namespace

void WriteTileTexture(const std::filesystem::path& path,
                      const TileTexture& texture,
                      const std::string& config) {
  Hdf5Writer file(
      path, kTextureFormat, kTextureVersion, config, "uv: shares of width and height of a page");
  WritePages(texture.pages, &file);
  Array<std::int32_t> charts{texture.charts.size(), 4, {}};
  for (const TextureChart& chart : texture.charts) {
    for (const std::int32_t number :
         {chart.component, chart.page, chart.num_vertices, chart.num_triangles}) {
      charts.values.push_back(number);
    }
  }
  file.Write("chart", charts);
  std::vector<std::int32_t> vertices;
  Array<float> uv{texture.vertices.size(), 2, {}};
  for (const TextureVertex& vertex : texture.vertices) {
    vertices.push_back(vertex.vertex);
    uv.values.insert(uv.values.end(), {vertex.uv.x(), vertex.uv.y()});
  }
  file.WriteList("vertex", vertices);
  file.Write("uv", uv);
  Array<std::int32_t> triangles{texture.triangles.size(), 3, {}};
  for (const Triangle& triangle : texture.triangles) {
    for (const std::uint32_t corner : triangle) {
      triangles.values.push_back(static_cast<std::int32_t>(corner));
    }
  }
  file.Write("triangle", triangles);
  file.Close();
}

TileTexture ReadTileTexture(const std::filesystem::path& path, const TileMesh& mesh) {
  const Hdf5Reader file(path, kTextureFormat, kTextureVersion);
  TileTexture texture;
  texture.pages = ReadPages(file);
  const auto charts = file.Read<std::int32_t>("chart", 4);
  for (std::size_t i = 0; i < charts.rows; ++i) {
    const std::int32_t* row = &charts.values[4 * i];
    texture.charts.push_back({row[0], row[1], row[2], row[3]});
  }
  const auto vertices = file.ReadList<std::int32_t>("vertex");
  const auto uv = file.Read<float>("uv", 2);
  file.Demand(uv.rows == vertices.size(), "uv");
  file.Demand(std::ranges::all_of(uv.values, [](float part) { return part >= 0 && part <= 1; }),
              "uv");
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    file.Demand(IsIndexOf(vertices[i], mesh.vertices.size()), "vertex");
    texture.vertices.push_back({vertices[i], {uv.values[2 * i], uv.values[2 * i + 1]}});
  }
  const auto triangles = file.Read<std::int32_t>("triangle", 3);
  for (std::size_t i = 0; i < triangles.rows; ++i) {
    Triangle& triangle = texture.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      triangle[k] = static_cast<std::uint32_t>(triangles.values[3 * i + k]);
    }
  }
  CheckCharts(file, texture, mesh);
  return texture;
}

}  // namespace nightmap
