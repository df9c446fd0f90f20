// SPDX-License-Identifier: Apache-2.0
// things: reads the labelled voxels, the octree and the lists of the tiles; writes things.json.
#include "stages/labels/things/things.h"

#include <spdlog/spdlog.h>

#include "pipeline/dense/octree_reader.h"
#include "pipeline/program/stage_main.h"

namespace {

using namespace nightmap;

ThingsInputs ReadInputs(const StageContext& context) {
  std::vector<Tile> tiles;
  for (const auto& path : context.Inputs("tile")) tiles.push_back(ReadTile(path));
  ThingsInputs inputs{ReadVoxelLabels(context.Input("voxels")),
                      LeavesOfFile(context.Input("octree")),
                      UniteKeyframes(tiles),
                      ReadCameras(context.Input("cameras"))};
  for (const Keyframe& keyframe : inputs.keyframes) {
    CheckCamera(keyframe.frame, inputs.cameras, context.Input("cameras").string());
  }
  return inputs;
}

void Run(const ThingsOptions& options, StageContext& context) {
  context.BeginPart("read");
  const ThingsInputs inputs = ReadInputs(context);
  context.BeginPart("find");
  const auto things = RunThings(options, inputs, context.GetProgress(), context.NumThreads());
  if (things.empty()) {
    spdlog::warn(
        "no things: none of the {} labelled voxels are {} together of one class; see classes, "
        "leave_out and min_voxels of things",
        inputs.voxels.Size(),
        options.min_voxels);
  }
  context.BeginPart("write");
  WriteFile(context.Output("things"), ThingsToJson(things));
  context.Report() = DescribeThings(things);
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{"things",
                       "finds the things that stand in the map, and the pictures that show them",
                       {{"voxels", "labels of the octree's occupied voxels"},
                        {"octree", "map.ot of the join_octrees stage"},
                        {"tile", "tile_X_Y.json of the tiles stage", Arity::kMany},
                        {"cameras", "cameras.json of the tiles stage"}},
                       {{"things", "things.json: class, upright box and best view of each thing"}}};
  return StageMain(argc, argv, spec, ThingsOptions{}, Run);
}
