// SPDX-License-Identifier: Apache-2.0
// octree: casts the keyframes' depth rays into an occupancy octree. Reads the frames, their pixels,
// keyframes.tum and the cloud; writes map.ot and map.bt.
#include <optional>

#include "pipeline/base/stage_main.h"
#include "stages/octree/octree.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"octree",
                       "marks the space of the building occupied, free or unknown",
                       {{"frames", "shard_NNNN.csv of the frames stage", Arity::kMany},
                        {"cameras", "cameras.json of the pose_graph stage"},
                        {"data", "folder the frames' paths are relative to"},
                        {"keyframes", "keyframes.tum of the pose_graph stage, map_from_camera"},
                        {"cloud", "cloud.ply of the point_cloud stage", Arity::kOptional}},
                       {{"ot", "map.ot: log-odds and color of each voxel (OctoMap ColorOcTree)"},
                        {"bt", "map.bt: occupied or free (OctoMap binary)"}}};
  return StageMain(
      argc, argv, spec, OctreeOptions{}, [](const OctreeOptions& options, StageContext& context) {
        context.BeginPart("open");
        const KeyframeSource source = OpenKeyframes(context.Inputs("frames"),
                                                    context.Input("cameras"),
                                                    context.Input("keyframes"),
                                                    context.Input("data"),
                                                    options.keyframe_stride);
        std::optional<std::vector<CloudPoint>> cloud;
        if (context.HasInput("cloud")) cloud = ReadPly(context.Input("cloud"));
        context.BeginPart("cast");
        const OctreeResult result = RunOctree(options,
                                              source,
                                              cloud ? &*cloud : nullptr,
                                              context.GetProgress(),
                                              context.NumThreads());
        for (const std::string& reason : result.skipped) context.Skip(reason);
        context.CheckSkipped(source.keyframes.size(), options.max_failed_ratio);
        context.BeginPart("write");
        WriteOctree(context.Output("ot"), result.tree);
        WriteBinaryOctree(context.Output("bt"), result.tree);
        context.Report()["num_keyframes"] = source.keyframes.size();
        context.Report()["num_rays"] = result.num_rays;
        context.Report()["num_unsupported"] = result.num_unsupported;
        context.Report()["num_occupied_voxels"] = result.num_occupied;
        context.Report()["num_free_voxels"] = result.num_free;
      });
}
