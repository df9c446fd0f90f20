// SPDX-License-Identifier: Apache-2.0
// mesh: reads the clouds in and around a tile; writes the surface of the tile as triangles.
#include "stages/dense/mesh/mesh.h"

#include "pipeline/dense/tile_config.h"
#include "pipeline/dense/tiles_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const MeshOptions& options, StageContext& context) {
  const Rectangle tile = ReadTile(context.Input("tile")).region.inside;
  MeshCloud cloud;
  cloud.voxel_size_m =
      TileConfig({context.Input("cloud_report")}).Number("voxel_size_m", Range(1e-6, 1e6));
  cloud.points =
      ReadPlyWithin(context.Inputs("cloud"), tile.Grown(MeshReach_m(options, cloud.voxel_size_m)));
  const TileMesh mesh = RunMesh(options, cloud, tile, context.NumThreads());
  WriteTileMesh(context.Output("tile_mesh"), mesh);
  context.Report()["num_vertices"] = mesh.vertices.size();
  context.Report()["num_triangles"] = mesh.triangles.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"mesh",
                       "makes the surface of a tile's cloud, as triangles in the map frame",
                       {{"tile", "tile_X_Y.json of the tiles stage"},
                        {"cloud", "tile_X_Y.ply of the tile and its neighbours", Arity::kMany},
                        {"cloud_report", "report_X_Y.json of the tile's cloud"}},
                       {{"tile_mesh", "tile_X_Y.ply: the part of the mesh in one tile"}}};
  return StageMain(argc, argv, spec, MeshOptions{}, Run);
}
