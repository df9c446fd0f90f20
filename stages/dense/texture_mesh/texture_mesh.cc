// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/texture_mesh.h"

#include <algorithm>
#include <map>

#include "pipeline/io/picture_file.h"
#include "stages/dense/texture_mesh/choose_views.h"
#include "stages/dense/texture_mesh/find_views.h"
#include "stages/dense/texture_mesh/pack_rectangles.h"
#include "stages/dense/texture_mesh/picture_chart.h"

namespace nightmap {
namespace {

constexpr int kJpegQuality = 90;

struct PlacedCharts {
  std::vector<ViewChart> views;
  std::vector<PictureChart> pictures;
  PackedRectangles packed;
  std::vector<bool> is_painted;  // by chart
};

PlacedCharts PlaceCharts(const TextureMeshOptions& options,
                         const TileMesh& mesh,
                         const KeyframeSource& source,
                         const std::vector<BestViews>& found,
                         int num_threads) {
  const auto neighbors = NeighborsOf(mesh.triangles);
  PlacedCharts charts;
  charts.views = ChartsOf(ChooseViews(found, neighbors), neighbors);
  charts.pictures.resize(charts.views.size());
  charts.is_painted.resize(charts.views.size());
  ParallelFor(charts.views.size(), num_threads, [&](std::size_t i) {
    const ViewChart& chart = charts.views[i];
    if (chart.view == kNoView) {
      charts.pictures[i] = ChartWithoutPicture(mesh, chart);
      return;
    }
    const Keyframe& keyframe = source.keyframes[chart.view];
    const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
    charts.pictures[i] = ChartInPicture(mesh,
                                        chart,
                                        source.cameras[camera].color,
                                        keyframe.map_from_camera,
                                        options.texel_m,
                                        options.page_px);
  });
  std::vector<Eigen::Vector2i> sizes;
  for (const PictureChart& chart : charts.pictures) sizes.push_back(chart.size);
  charts.packed = PackRectangles(sizes, options.page_px);
  return charts;
}

void Paste(const ColorImage& from, const Eigen::Vector2i& corner, ColorImage& to) {
  const auto row = static_cast<std::ptrdiff_t>(from.width) * 3;
  for (int y = 0; y < from.height; ++y) {
    std::copy_n(from.pixels.begin() + y * row, row, &to.At(corner.x(), corner.y() + y));
  }
}

std::vector<ColorImage> EmptyPages(const std::vector<Eigen::Vector2i>& sizes) {
  std::vector<ColorImage> pages;
  for (const Eigen::Vector2i& size : sizes) {
    ColorImage& page = pages.emplace_back(ColorImage{size.x(), size.y(), 3, {}});
    page.pixels.resize(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) * 3,
                       128);
  }
  return pages;
}

struct CutChart {
  std::size_t chart = 0;
  ColorImage texels;
};

// Returns the pages; adds the keyframes that cannot be read to `result`.
std::vector<ColorImage> PaintPages(const TileMesh& mesh,
                                   const KeyframeSource& source,
                                   Progress& progress,
                                   int num_threads,
                                   PlacedCharts& charts,
                                   TextureMeshResult& result) {
  std::map<std::uint32_t, std::vector<std::size_t>> charts_of;  // by view
  for (std::size_t i = 0; i < charts.views.size(); ++i) {
    if (charts.views[i].view != kNoView) charts_of[charts.views[i].view].push_back(i);
  }
  KeyframeSource used = source;
  used.keyframes.clear();
  std::map<int, const std::vector<std::size_t>*> wanted;  // by keyframe_idx
  for (const auto& [view, some] : charts_of) {
    used.keyframes.push_back(source.keyframes[view]);
    wanted[source.keyframes[view].keyframe_idx] = &some;
  }
  std::vector<ColorImage> pages = EmptyPages(charts.packed.pages);
  result.skipped = FuseKeyframes<std::vector<CutChart>>(
      used,
      progress,
      num_threads,
      [&](const Keyframe& keyframe, const RgbdImages& images) {
        std::vector<CutChart> cuts;
        for (const std::size_t i : *wanted.at(keyframe.keyframe_idx)) {
          cuts.push_back({i, CutFromPicture(mesh, charts.pictures[i], images.color)});
        }
        return cuts;
      },
      [&](std::vector<CutChart>&& cuts) {
        ++result.num_views;
        for (const CutChart& cut : cuts) {
          const PackedRectangle& place = charts.packed.places[cut.chart];
          Paste(cut.texels, place.corner, pages[place.page]);
          charts.is_painted[cut.chart] = true;
        }
      });
  return pages;
}

std::vector<std::int32_t> ComponentsOfTriangles(const TileMesh& mesh) {
  std::vector<std::int32_t> components;
  for (std::size_t i = 0; i < mesh.components.size(); ++i) {
    components.insert(
        components.end(), mesh.components[i].num_triangles, static_cast<std::int32_t>(i));
  }
  return components;
}

void AddCharts(const TileMesh& mesh, const PlacedCharts& charts, TextureMeshResult& result) {
  const auto components = ComponentsOfTriangles(mesh);
  for (std::size_t i = 0; i < charts.pictures.size(); ++i) {
    const PictureChart& chart = charts.pictures[i];
    const PackedRectangle& place = charts.packed.places[i];
    TileTexture& texture = result.texture;
    texture.charts.push_back(
        {components[charts.views[i].triangles.front()],
         charts.is_painted[i] ? static_cast<std::int32_t>(place.page) : TextureChart::kNoPage,
         static_cast<std::int32_t>(chart.vertices.size()),
         static_cast<std::int32_t>(chart.triangles.size())});
    for (std::size_t k = 0; k < chart.vertices.size(); ++k) {
      TextureVertex vertex{static_cast<std::int32_t>(chart.vertices[k]), {0, 0}};
      if (charts.is_painted[i]) {
        const Eigen::Array2d texel =
            chart.TexelOf(chart.pixels[k]).array() + place.corner.array().cast<double>() + 0.5;
        const Eigen::Array2d page = charts.packed.pages[place.page].array().cast<double>();
        vertex.uv = (texel / page).cast<float>();
      }
      texture.vertices.push_back(vertex);
    }
    texture.triangles.insert(
        texture.triangles.end(), chart.triangles.begin(), chart.triangles.end());
    if (!charts.is_painted[i]) continue;
    ++result.num_textured_charts;
    result.num_textured_triangles += chart.triangles.size();
  }
}

}  // namespace

TextureMeshResult RunTextureMesh(const TextureMeshOptions& options,
                                 const TileMesh& mesh,
                                 const KeyframeSource& source,
                                 Progress& progress,
                                 int num_threads) {
  const FoundViews found = FindViews(mesh, source, options.texel_m, progress, num_threads);
  PlacedCharts charts = PlaceCharts(options, mesh, source, found.of_triangles, num_threads);
  TextureMeshResult result;
  const std::vector<ColorImage> pages =
      PaintPages(mesh, source, progress, num_threads, charts, result);
  result.skipped.insert(result.skipped.begin(), found.skipped.begin(), found.skipped.end());
  result.texture.pages.resize(pages.size());
  ParallelFor(pages.size(), num_threads, [&](std::size_t i) {
    result.texture.pages[i] = EncodeJpeg(pages[i], kJpegQuality, JpegColors::kFull);
  });
  AddCharts(mesh, charts, result);
  return result;
}

}  // namespace nightmap
