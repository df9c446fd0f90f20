// SPDX-License-Identifier: Apache-2.0
// texture_mesh: pictures of the keyframes on the triangles of a tile.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/dense/mesh_io.h"
#include "pipeline/dense/rgbd_keyframes.h"
#include "pipeline/dense/tile_texture_io.h"

namespace nightmap {

struct TextureMeshOptions {
  OPTION(double, texel_m, 0.005, {0.0005, 0.1},
         "edge of the finest texel on the surface: pictures from nearer are scaled down to it, "
         "none are scaled up");
  OPTION(int, page_px, 4096, {256, 16384},
         "largest width and height of a page of texture");
  REGISTER_OPTIONS();
};

struct TextureMeshResult {
  TileTexture texture;
  std::size_t num_textured_triangles = 0;
  std::size_t num_textured_charts = 0;
  std::size_t num_views = 0;         // keyframes whose pictures are on the mesh
  std::vector<std::string> skipped;  // why keyframes were left out
};

// Gives each triangle the picture of a keyframe that sees all of it, as the depth there says, from
// near and the front; neighbours have the same one where these views are about as good (a Markov
// random field in Waechter, Moehrle and Goesele, Let There Be Color, ECCV 2014; greedy here).
// Charts, triangles that hang together in one picture, are cut from it as they are, lens and all,
// and their colors are scaled to the mean of the colors of their vertices. Triangles that no
// keyframe sees are in charts without a page.
//
// Holds the texture, kMaxViews views of each triangle, and the pixels of four keyframes per thread.
// Same result at any number of threads.
TextureMeshResult RunTextureMesh(const TextureMeshOptions& options,
                                 const TileMesh& mesh,
                                 const KeyframeSource& source,
                                 Progress& progress,
                                 int num_threads);

}  // namespace nightmap
