// SPDX-License-Identifier: Apache-2.0
// A chart as it lies in the picture of its view, and the texels cut from there.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/dense/mesh_io.h"
#include "pipeline/io/frames_io.h"
#include "stages/dense/texture_mesh/choose_views.h"

namespace nightmap {

struct PictureChart {
  std::vector<std::uint32_t> vertices;  // of the mesh, in order of their first triangle
  std::vector<Triangle> triangles;      // of these
  std::vector<Eigen::Vector2d> pixels;  // of the vertices; none without a view
  double scale = 1;                     // texels per pixel
  Eigen::Vector2d origin = {0, 0};      // pixel of the first texel
  Eigen::Vector2i size = {0, 0};        // texels, with a gutter around the triangles

  // Texel of a pixel, from the centre of the first one.
  Eigen::Vector2d TexelOf(const Eigen::Vector2d& pixel) const { return (pixel - origin) * scale; }
};

// Vertices and triangles alone.
PictureChart ChartWithoutPicture(const TileMesh& mesh, const ViewChart& chart);

// The chart at the scale of the picture, or smaller: pixels are not finer than texel_m on the mean
// triangle, and the chart fits a page of page_px. The camera must see all its vertices.
PictureChart ChartInPicture(const TileMesh& mesh,
                            const ViewChart& chart,
                            const Camera& camera,
                            const Rigid3& map_from_camera,
                            double texel_m,
                            int page_px);

// The texels of the chart: each the mean of the pixels that it covers. Red, green and blue are
// scaled to the colors of the vertices in the mean over the chart, at most by half or double.
ColorImage CutFromPicture(const TileMesh& mesh, const PictureChart& chart, const ColorImage& color);

}  // namespace nightmap
