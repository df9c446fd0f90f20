// SPDX-License-Identifier: Apache-2.0
// join_meshes: joins the meshes of a building's tiles into one mesh.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/dense/mesh_io.h"

namespace nightmap {

struct JoinMeshesOptions {
  OPTION(double, min_component_m2, 0.02, {0.0, 1e6},
         "area below which triangles that hang together, and with no others, are left out");
  REGISTER_OPTIONS();
};

// Returns the mesh of a tile, the same each time.
using TileMeshSource = std::function<TileMesh(std::size_t tile)>;

struct JoinedMesh {
  MeshSize size;
  Eigen::AlignedBox3f box_in_map;  // of the vertices
  std::size_t num_components = 0;
  std::size_t num_dropped_components = 0;
  std::vector<std::vector<bool>> is_kept;  // of each tile, by component
};

// Takes the joined mesh: once `begin`, then each vertex, then each triangle.
struct MeshSink {
  std::function<void(const JoinedMesh&)> begin;
  std::function<void(const MeshVertex&)> vertex;
  std::function<void(const Triangle&)> triangle;
};

// Vertices on seams of tiles that have equal positions become one; components are joined by them.
// Calls `load` three times per tile. Holds one tile in memory, all vertices on seams, and a few
// numbers per component. Throws DataError when nothing is left, or there are more vertices than a
// PLY or GLB can number.
JoinedMesh RunJoinMeshes(const JoinMeshesOptions& options,
                         std::size_t num_tiles,
                         const TileMeshSource& load,
                         const MeshSink& sink);

}  // namespace nightmap
