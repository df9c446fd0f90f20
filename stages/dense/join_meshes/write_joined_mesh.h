// SPDX-License-Identifier: Apache-2.0
// The files of the joined mesh.
#pragma once

#include "pipeline/program/stage_context.h"
#include "stages/dense/join_meshes/join_meshes.h"

namespace nightmap {

// Reads the inputs tile, tile_mesh and tile_report of the same tiles. Writes the outputs mesh (PLY)
// and glb. Removes files of other tiles from the folder of the outputs.
void WriteJoinedMesh(const JoinMeshesOptions& options, StageContext& context);

}  // namespace nightmap
