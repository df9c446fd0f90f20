// SPDX-License-Identifier: Apache-2.0
// localize: reads query pictures and the landmark map; writes queries.csv (every query, failures
// with their reason) and queries.tum (the located ones).
#include <opencv2/core.hpp>

#include "pipeline/io/frame_reader.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/camera/localize/describe_picture.h"
#include "stages/camera/localize/localize_report.h"
#include "stages/camera/localize/map_parts.h"
#include "stages/camera/localize/query_cameras.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "localize",
      "finds the pose of each query picture from the picture alone",
      {{"queries", "queries.csv of the queries stage"},
       {"cameras", "query_cameras.json of the queries stage"},
       {"configured", "cameras.json of the frames stage"},
       {"calibrated", "cameras.json of the adjust stage"},
       FolderPort("data", "folder to which the paths in queries are relative"),
       {"masks", "masks of the queries: what moves in them", Arity::kAnyNumber},
       {"landmarks", "landmarks.h5"},
       {"vocabulary", "vocabulary.h5"}},
      {{"queries", "queries.csv: every query with the verdict and its reason"},
       {"trajectory", "queries.tum: map_from_camera of the located queries", Arity::kOptional}}};
  return StageMain(
      argc, argv, spec, LocalizeOptions{}, [](const auto& options, StageContext& context) {
        cv::setNumThreads(1);  // pictures are the unit of parallelism
        context.BeginPart("read");
        LandmarksReader landmarks(context.Input("landmarks"));
        const auto map = RegionsOf(landmarks);
        const VocabularyIndex vocabulary = OpenVocabulary(context.Input("vocabulary"));
        const FrameReader reader(context.Input("data"), context.Inputs("masks"));
        const auto map_cameras = ReadCameras(context.Input("calibrated"));
        const auto queries = ReadFrames(context.Input("queries"));
        const LocalizeInput input{queries,
                                  WithCalibration(ReadCameras(context.Input("cameras"), queries),
                                                  ReadCameras(context.Input("configured")),
                                                  map_cameras),
                                  ExtractionOf(map.head, context.Input("landmarks").string()),
                                  &map,
                                  &vocabulary,
                                  [&](const FrameRecord& query, const RgbdCamera& camera) {
                                    return reader.Color(query, camera);
                                  },
                                  [&](const std::string& problem) { context.Skip(problem); },
                                  [&](const char* part) { context.BeginPart(part); },
                                  map_cameras};
        const auto found = RunLocalize(options, input, context.GetProgress(), context.NumThreads());
        context.BeginPart("write");
        WriteFile(context.Output("queries"), QueriesToCsv(found));
        context.WriteIfWanted("trajectory", [&] {
          return TrajectoryToTum(LocatedPoses(found), "map_from_camera of the located queries");
        });
        context.Report().update(SummarizeQueries(found));
      });
}
