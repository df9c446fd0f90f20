// SPDX-License-Identifier: Apache-2.0
// The files of the joined mesh.
#pragma once

#include "pipeline/program/stage_context.h"
#include "stages/dense/join_meshes/join_meshes.h"

namespace nightmap {

// Reads the inputs tile, tile_mesh, tile_report, tile_texture and texture_report of the same tiles.
// Writes the outputs mesh (PLY), glb and textured (GLB). Removes files of other tiles from the
// folders of the outputs and of the textures.
void WriteJoinedMesh(const JoinMeshesOptions& options, StageContext& context);

}  // namespace nightmap
