// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/join_labels/write_joined_labels.h"

#include "pipeline/base/files.h"
#include "pipeline/dense/octree_reader.h"
#include "pipeline/dense/tile_results.h"

namespace nightmap {
namespace {

VoxelLabels ReadParts(const std::vector<std::filesystem::path>& paths) {
  std::vector<VoxelLabels> parts;
  for (const auto& path : paths) parts.push_back(ReadVoxelLabels(path));
  return JoinVoxelLabels(parts);
}

void LabelCloud(const std::filesystem::path& from,
                const std::filesystem::path& to,
                const VoxelLabels& voxels) {
  const LabelAt label_at(voxels);
  PlyReader reader(from);
  PlyWriter writer(to, reader.NumPoints(), PlyLabels::kUintAndScalar);
  while (auto point = reader.Next()) {
    point->label = label_at(point->position_in_map.cast<double>());
    writer.Add(*point);
  }
  writer.Close();
}

void ReportClasses(const VoxelLabels& voxels, StageContext& context) {
  const auto counts = CountClasses(voxels);
  nlohmann::ordered_json num_voxels = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) num_voxels[voxels.classes[i]] = counts[i];
  }
  context.Report()["num_labelled_voxels"] = voxels.Size();
  context.Report()["num_voxels_of_class"] = num_voxels;
}

}  // namespace

void WriteJoinedLabels(const JoinLabelsOptions& options, StageContext& context) {
  const auto& tiles = context.Inputs("tile");
  const TileResults results = CheckTileParts(context, "tile_labels", options.max_failed_ratio);
  context.BeginPart("join");
  const VoxelLabels voxels = ReadParts(context.Inputs("tile_labels"));
  const std::vector<Rgb> palette = MakePalette(options.palette, voxels.classes.size());
  context.BeginPart("write");
  WriteVoxelLabels(context.OutputBeside("ot", "voxels.h5"), voxels, "");
  WriteLabelledOctree(context.Output("ot"), LeavesOfFile(context.Input("octree")), voxels, palette);
  WriteFile(context.Output("legend"), LegendJson(voxels, palette));
  LabelCloud(context.Input("cloud"), context.Output("cloud"), voxels);
  RemoveOtherTiles(std::filesystem::absolute(context.FinalPath("ot")).parent_path(), tiles);
  context.Report()["num_tiles"] = tiles.size();
  context.Report()["num_keyframes"] = results.num_keyframes;
  ReportClasses(voxels, context);
}

}  // namespace nightmap
