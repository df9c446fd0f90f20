// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/write_joined_mesh.h"

#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/dense/tile_results.h"
#include "stages/dense/join_meshes/glb_io.h"

namespace nightmap {

void WriteJoinedMesh(const JoinMeshesOptions& options, StageContext& context) {
  const auto& tiles = context.Inputs("tile");
  const auto& meshes = context.Inputs("tile_mesh");
  const auto& reports = context.Inputs("tile_report");
  if (meshes.size() != tiles.size() || reports.size() != tiles.size()) {
    throw UsageError("to join tiles give as many tile_mesh and tile_report as tile: {}, {} and {}",
                     meshes.size(),
                     reports.size(),
                     tiles.size());
  }
  const TileConfig same_config(reports);  // or an error
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
  const JoinedMesh joined =
      RunJoinMeshes(options,
                    meshes.size(),
                    [&](std::size_t tile) { return ReadTileMesh(meshes[tile]); },
                    {begin, add, add});
  ply->Close();
  glb->Close();
  RemoveOtherTiles(std::filesystem::absolute(context.FinalPath("mesh")).parent_path(), tiles);
  auto& report = context.Report();
  report["num_tiles"] = tiles.size();
  report["num_vertices"] = joined.size.num_vertices;
  report["num_triangles"] = joined.size.num_triangles;
  report["num_components"] = joined.num_components;
  report["num_dropped_components"] = joined.num_dropped_components;
}

}  // namespace nightmap
