// SPDX-License-Identifier: Apache-2.0
// landmarks: reads features and the optimized poses, writes landmarks.h5, the map that pictures are
// localized against, and the same map as a COLMAP model and database.
#include <spdlog/spdlog.h>

#include "pipeline/base/stage_main.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/vision/vocabulary_io.h"
#include "stages/landmarks/colmap_export.h"
#include "stages/landmarks/landmarks_report.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"landmarks",
                       "joins features to 3-D landmarks with descriptors, words and visibility",
                       {{"frames", "shards of the frames stage, in order", Arity::kMany},
                        {"cameras", "cameras.json of the pose_graph stage"},
                        {"features", "shards of the features stage, in order", Arity::kMany},
                        {"vocabulary", "vocabulary.h5"},
                        {"trajectory", "trajectory.tum of the pose_graph stage"},
                        {"keyframes", "keyframes.tum of the pose_graph stage"}},
                       {{"landmarks", "landmarks.h5"},
                        {"cameras.txt", "COLMAP model as text"},
                        {"images.txt", "of that model"},
                        {"points3D.txt", "of that model"},
                        {"cameras.bin", "the same model, binary"},
                        {"images.bin", "of that model"},
                        {"points3D.bin", "of that model"},
                        {"database", "COLMAP database of its images"}}};
  return StageMain(
      argc, argv, spec, LandmarksOptions{}, [](const auto& options, StageContext& context) {
        context.BeginPart("read");
        const VocabularyTree tree = ReadVocabulary(context.Input("vocabulary")).tree;
        const auto frames = ReadFrames(context.Inputs("frames"));
        const LandmarksInput input{frames,
                                   ReadCameras(context.Input("cameras"), frames),
                                   ReadFeatures(context.Inputs("features")),
                                   &tree,
                                   ReadTum(context.Input("trajectory")),
                                   ReadTum(context.Input("keyframes"))};
        context.BeginPart("build");
        const LandmarksResult result =
            RunLandmarks(options, input, context.GetProgress(), context.NumThreads());
        const LandmarkMap& map = result.map;
        const std::string dropped = DroppedLandmarks(result);
        if (!dropped.empty()) spdlog::warn("{}", dropped);
        if (map.NumLandmarks() == 0) {
          throw ThresholdError(
              "landmarks: none; see min_observations and the depth in the features");
        }
        context.BeginPart("write");
        WriteLandmarks(context.Output("landmarks"), map, context.ConfigToml());
        context.BeginPart("export");
        const ColmapModel model = MakeColmapModel(input, map);
        for (const auto& [name, bytes] : ColmapFiles(model)) WriteFile(context.Output(name), bytes);
        WriteColmapDatabase(context.Output("database"), model);
        const std::string unusable_names = UnusableColmapNames(model);
        if (!unusable_names.empty()) spdlog::warn("COLMAP export: {}", unusable_names);
        context.Report().update(SummarizeLandmarks(result));
        context.Report()["num_colmap_points"] = model.points.size();
        context.Report()["mean_reprojection_error_px"] = model.MeanReprojectionError_px();
        context.Report()["colmap_names_usable"] = unusable_names.empty();
        if (!unusable_names.empty()) context.Report()["colmap_names_reason"] = unusable_names;
      });
}
