// SPDX-License-Identifier: Apache-2.0
// The joined mesh with the pages of its tiles as one GLB.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include "pipeline/dense/tile_texture_io.h"
#include "stages/dense/join_meshes/join_meshes.h"

namespace nightmap {

// Returns the texture of a tile, the same each time; its mesh is given.
using TileTextureSource = std::function<TileTexture(std::size_t tile, const TileMesh& mesh)>;

struct TexturedSize {
  std::size_t num_triangles = 0;
  std::size_t num_textured_triangles = 0;
  std::size_t num_pages = 0;
};

// Writes the triangles of the components that are kept, in axes and units of GlbWriter: for each
// page of a tile a primitive with TEXCOORD_0, a material and a picture; for the triangles of a tile
// without a picture one with COLOR_0. Materials are unlit. A vertex is in each chart that it
// touches. Loads each tile twice and holds one. Throws DataError as GlbWriter does.
TexturedSize WriteTexturedGlb(const std::filesystem::path& path,
                              const JoinedMesh& joined,
                              const TileMeshSource& load_mesh,
                              const TileTextureSource& load_texture);

}  // namespace nightmap
