// SPDX-License-Identifier: Apache-2.0
// point_cloud: fuses the depth of all keyframes to one cloud. Reads the frames, their pixels and
// keyframes.tum; writes cloud.ply.
#include "pipeline/base/stage_main.h"
#include "pipeline/io/ply_io.h"
#include "stages/point_cloud/point_cloud.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"point_cloud",
                       "fuses the depth of all keyframes to one point cloud in the map frame",
                       {{"frames", "shard_NNNN.csv of the frames stage", Arity::kMany},
                        {"cameras", "cameras.json of the pose_graph stage"},
                        {"data", "folder the frames' paths are relative to"},
                        {"keyframes", "keyframes.tum of the pose_graph stage, map_from_camera"}},
                       {{"cloud", "cloud.ply: position, normal, color and label of each point"}}};
  return StageMain(argc,
                   argv,
                   spec,
                   PointCloudOptions{},
                   [](const PointCloudOptions& options, StageContext& context) {
                     context.BeginPart("open");
                     const KeyframeSource source = OpenKeyframes(context.Inputs("frames"),
                                                                 context.Input("cameras"),
                                                                 context.Input("keyframes"),
                                                                 context.Input("data"),
                                                                 options.keyframe_stride);
                     context.BeginPart("fuse");
                     const PointCloudResult result = RunPointCloud(
                         options, source, context.GetProgress(), context.NumThreads());
                     for (const std::string& reason : result.skipped) context.Skip(reason);
                     context.CheckSkipped(source.keyframes.size(), options.max_failed_ratio);
                     context.BeginPart("write");
                     WritePly(context.Output("cloud"), result.points);
                     context.Report()["num_keyframes"] = source.keyframes.size();
                     context.Report()["num_measurements"] = result.num_measurements;
                     context.Report()["num_voxels"] = result.num_voxels;
                     context.Report()["num_outliers"] = result.num_outliers;
                     context.Report()["num_points"] = result.points.size();
                   });
}
