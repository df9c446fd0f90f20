// SPDX-License-Identifier: Apache-2.0
// Orders a mesh by its connected components.
#pragma once

#include <vector>

#include "pipeline/dense/mesh_io.h"

namespace nightmap {

// Vertices without a triangle are left out. A component is as early as its first vertex; its
// vertices and triangles keep their order, but those on seams (is_on_seam, per vertex) come first.
TileMesh GroupComponents(const std::vector<MeshVertex>& vertices,
                         const std::vector<bool>& is_on_seam,
                         const std::vector<Triangle>& triangles);

}  // namespace nightmap
