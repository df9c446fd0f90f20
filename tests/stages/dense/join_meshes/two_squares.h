// SPDX-License-Identifier: Apache-2.0
// Meshes of two tiles, with pictures on one square.
#pragma once

#include <vector>

#include "pipeline/dense/tile_texture_io.h"

namespace nightmap {

inline MeshVertex VertexAt(float x_m, float y_m) {
  return {{x_m, y_m, 7}, {0, 0, 1}, {255, 0, 128}};
}

// The squares (0, 0) to (1, 1) and (1, 0) to (2, 1), which share an edge on the seam x = 1, and in
// the left tile a triangle of 0.5 cm2 apart from them.
inline std::vector<TileMesh> TwoSquares() {
  TileMesh left, right;
  left.vertices = {VertexAt(1, 0), VertexAt(1, 1), VertexAt(0, 0), VertexAt(0, 1)};
  left.triangles = {{2, 0, 3}, {0, 1, 3}, {4, 5, 6}};
  for (const float x_m : {0.50F, 0.51F}) left.vertices.push_back(VertexAt(x_m, 5));
  left.vertices.push_back(VertexAt(0.5F, 5.01F));
  left.components = {{4, 2, 2, 1.0}, {3, 0, 1, 0.5e-4}};
  right.vertices = {VertexAt(1, 0), VertexAt(1, 1), VertexAt(2, 0), VertexAt(2, 1)};
  right.triangles = {{0, 2, 1}, {2, 3, 1}};
  right.components = {{4, 2, 2, 1.0}};
  return {left, right};
}

// A page for the left square and one for the small triangle; the right square has one triangle on a
// page and one without.
inline std::vector<TileTexture> TwoTextures() {
  TileTexture left, right;
  left.pages = {"left", "small"};
  left.charts = {{0, 0, 4, 2}, {1, 1, 3, 1}};
  left.vertices = {{2, {0, 1}}, {0, {1, 1}}, {3, {0, 0}}, {1, {1, 0}}, {4}, {5}, {6}};
  left.triangles = {{0, 1, 2}, {1, 3, 2}, {0, 1, 2}};
  right.pages = {"right"};
  right.charts = {{0, TextureChart::kNoPage, 3, 1}, {0, 0, 3, 1}};
  right.vertices = {{0}, {2}, {1}, {2, {0.25F, 0}}, {3, {0.5F, 0}}, {1, {0.25F, 0.5F}}};
  right.triangles = {{0, 1, 2}, {0, 1, 2}};
  return {left, right};
}

}  // namespace nightmap
