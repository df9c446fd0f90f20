// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/write_joined_mesh.h"

#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/dense/tile_results.h"
#include "stages/dense/join_meshes/glb_io.h"
#include "stages/dense/join_meshes/textured_glb.h"

namespace nightmap {

void WriteJoinedMesh(const JoinMeshesOptions& options, StageContext& context) {
  const auto& tiles = context.Inputs("tile");
  const auto& meshes = context.Inputs("tile_mesh");
  const auto& reports = context.Inputs("tile_report");
  const auto& textures = context.Inputs("tile_texture");
  const auto& texture_reports = context.Inputs("texture_report");
  for (const auto* some : {&meshes, &reports, &textures, &texture_reports}) {
    if (some->size() == tiles.size()) continue;
    throw UsageError(
        "to join tiles give as many tile_mesh, tile_report, tile_texture and texture_report as "
        "tile: {}, {}, {}, {} and {}",
        meshes.size(),
        reports.size(),
        textures.size(),
        texture_reports.size(),
        tiles.size());
  }
  const TileConfig same_config(reports), same_texels(texture_reports);  // or an error
  const auto load = [&](std::size_t tile) { return ReadTileMesh(meshes[tile]); };
  std::optional<MeshPlyWriter> ply;
  std::optional<GlbWriter> glb;
  const auto add = [&](const auto& piece) {
    ply->Add(piece);
    glb->Add(piece);
  };
  const auto begin = [&](const JoinedMesh& joined) {
    ply.emplace(context.Output("mesh"), joined.size);
    glb.emplace(context.Output("glb"), joined.size, joined.box_in_map);
  };
  const JoinedMesh joined = RunJoinMeshes(options, meshes.size(), load, {begin, add, add});
  ply->Close();
  glb->Close();
  const TexturedSize textured = WriteTexturedGlb(
      context.Output("textured"), joined, load, [&](std::size_t tile, const TileMesh& mesh) {
        return ReadTileTexture(textures[tile], mesh);
      });
  RemoveOtherTiles(std::filesystem::absolute(context.FinalPath("mesh")).parent_path(), tiles);
  RemoveOtherTiles(std::filesystem::absolute(textures.front()).parent_path(), tiles);
  auto& report = context.Report();
  report["num_tiles"] = tiles.size();
  report["num_vertices"] = joined.size.num_vertices;
  report["num_triangles"] = joined.size.num_triangles;
  report["num_components"] = joined.num_components;
  report["num_dropped_components"] = joined.num_dropped_components;
  report["num_textured_triangles"] = textured.num_textured_triangles;
  report["num_pages"] = textured.num_pages;
}

}  // namespace nightmap
