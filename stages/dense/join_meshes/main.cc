// SPDX-License-Identifier: Apache-2.0
// join_meshes: reads meshes and textures of all tiles; writes mesh.ply, mesh.glb and
// mesh_textured.glb.
#include "pipeline/program/stage_main.h"
#include "stages/dense/join_meshes/write_joined_mesh.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "join_meshes",
      "joins the meshes of all tiles into one, as PLY and as GLB",
      {{"tile", "tile_X_Y.json of the tiles stage", Arity::kMany},
       {"tile_mesh", "tile_X_Y.ply of the same tiles, in order", Arity::kMany},
       {"tile_report", "report_X_Y.json of the same meshes, in order", Arity::kMany},
       {"tile_texture", "tile_X_Y.h5 of the same meshes, in order", Arity::kMany},
       {"texture_report", "report_X_Y.json of the same textures, in order", Arity::kMany}},
      {{"mesh", "mesh.ply: vertices with normal and color, in the map frame; triangles"},
       {"glb", "mesh.glb: the same as glTF 2.0, y up"},
       {"textured", "mesh_textured.glb: likewise, with pictures of the keyframes"}}};
  return StageMain(argc, argv, spec, JoinMeshesOptions{}, WriteJoinedMesh);
}
