// SPDX-License-Identifier: Apache-2.0
// landmarks: reads features and the optimized poses, writes landmarks.h5, the map that pictures are
// localized against, and the same map as a COLMAP model and database.
#include <spdlog/spdlog.h>

#include "pipeline/camera/vocabulary_io.h"
#include "pipeline/io/landmarks_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/camera/landmarks/landmarks_report.h"
#include "stages/camera/landmarks/read_inputs.h"
#include "stages/camera/landmarks/write_colmap.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "landmarks",
      "joins features into 3-D landmarks with descriptors, words and visibility",
      {{"frames", "shards of the frames stage, in order", Arity::kMany},
       {"cameras", "cameras.json of the adjust stage"},
       {"features", "shards of the features stage, in order", Arity::kMany},
       {"vocabulary", "vocabulary.h5"},
       {"trajectory", "trajectory.tum of the map_frame stage"},
       {"keyframes", "keyframes.tum of the map_frame stage"},
       {"masked_frames", "list of frames with masks of what stays out", Arity::kOptional},
       {"masks", "these masks", Arity::kAnyNumber, PortKind::kByHash}},
      {{"landmarks", "landmarks.h5"},
       {"cameras.txt", "COLMAP model as text", Arity::kOptional},
       {"images.txt", "of that model", Arity::kOptional},
       {"points3D.txt", "of that model", Arity::kOptional},
       {"cameras.bin", "the same model, binary", Arity::kOptional},
       {"images.bin", "of that model", Arity::kOptional},
       {"points3D.bin", "of that model", Arity::kOptional},
       {"database", "COLMAP database of its images", Arity::kOptional}}};
  return StageMain(
      argc, argv, spec, LandmarksOptions{}, [](const auto& options, StageContext& context) {
        CheckColmapOutputs(context);
        context.BeginPart("read");
        const VocabularyTree tree = ReadVocabularyTree(context.Input("vocabulary"));
        const LandmarksInput input = ReadLandmarksInput(tree, context);
        context.BeginPart("build");
        const auto path = context.Output("landmarks");
        LandmarksWriter writer(path, HeadOfMap(options, input), context.ConfigToml());
        const auto write = [&](const Rectangle& box, const LandmarkMap& region) {
          writer.Write(box, region);
        };
        const LandmarksFigures figures =
            RunLandmarks(options, input, write, context.GetProgress(), context.NumThreads());
        writer.Close();
        const std::string dropped = DroppedLandmarks(figures);
        if (!dropped.empty()) spdlog::warn("{}", dropped);
        if (figures.num_landmarks == 0) {
          throw ThresholdError(
              "landmarks: none; see min_observations and the depth in the features");
        }
        context.Report().update(SummarizeLandmarks(figures));
        context.BeginPart("export");
        WriteColmap(input, path, context);
      });
}
