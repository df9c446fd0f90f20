// SPDX-License-Identifier: Apache-2.0
// texture_mesh: reads the mesh of one tile and the pixels of its keyframes; writes pages of texture
// and where on them the triangles lie.
#include "stages/dense/texture_mesh/texture_mesh.h"

#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const TextureMeshOptions& options, StageContext& context) {
  const KeyframeSource source = OpenTile(context, 1, 0);
  const TileMesh mesh = ReadTileMesh(context.Input("tile_mesh"));
  const TextureMeshResult result =
      RunTextureMesh(options, mesh, source, context.GetProgress(), context.NumThreads());
  for (const std::string& reason : result.skipped) context.Skip(reason);
  WriteTileTexture(context.Output("tile_texture"), result.texture, context.ConfigToml());
  auto& report = context.Report();
  report["num_keyframes_listed"] = source.keyframes.size();
  report["num_views"] = result.num_views;
  report["num_triangles"] = mesh.triangles.size();
  report["num_textured_triangles"] = result.num_textured_triangles;
  report["num_textured_charts"] = result.num_textured_charts;
  report["num_pages"] = result.texture.pages.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"texture_mesh",
                       "puts the pictures of keyframes on the mesh of a tile",
                       {{"tile", "tile_X_Y.json of the tiles stage"},
                        {"cameras", "cameras.json of the tiles stage"},
                        FolderPort("data", "folder to which the frames' paths are relative"),
                        {"masks",
                         "shard_NNNN.h5 of masks: what moves in the frames",
                         Arity::kAnyNumber,
                         PortKind::kByHash},
                        {"tile_mesh", "tile_X_Y.ply of the mesh stage"}},
                       {{"tile_texture", "tile_X_Y.h5: pages of texture for that mesh"}}};
  return StageMain(argc, argv, spec, TextureMeshOptions{}, Run);
}
