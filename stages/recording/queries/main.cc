// SPDX-License-Identifier: Apache-2.0
// queries: lists the pictures to locate. Reads the site config, the frames that the frames stage
// held out, and the pictures of [[query]] tables, also those that QUERY asks for, but no recording.
// Writes queries.txt and, next to it, queries.csv, query_cameras.json and query_ground_truth.tum.
#include "stages/recording/queries/queries.h"

#include <spdlog/spdlog.h>

#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "pipeline/recording/camera_masks.h"
#include "pipeline/recording/inspect_frames.h"
#include "pipeline/recording/site_config.h"
#include "pipeline/recording/truths_apart.h"
#include "stages/recording/queries/picture_cameras.h"
#include "stages/recording/queries/write_queries.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "queries",
      "lists the pictures to locate in a site's map, with their cameras",
      {CheckedPort("site", "site config, configs/sites/<site>.toml", CheckSiteConfig),
       CheckedPort("asked", "[[query]] tables of QUERY", "site", CheckAskedQueries),
       FolderPort("data", "folder of the recordings"),
       {"held_out", "held_out.csv of the frames stage"},
       {"held_out_truth", "held_out.tum of the frames stage"}},
      {{"list", "queries.txt; the other files are written next to it"}}};
  return StageMain(
      argc, argv, spec, QueriesOptions{}, [](const QueriesOptions& options, StageContext& context) {
        const auto& data_root = context.Input("data");
        SiteConfig site = ReadSiteConfig(context.Input("site"));
        ReadAskedQueries(context.Input("asked"), &site);
        for (const ScanQueryConfig& scans : site.scan_queries) {
          spdlog::warn("{}: laser scans are located by profile laser alone", scans.source);
        }
        context.BeginPart("list");
        const auto held_out = ReadFrames(context.Input("held_out"));
        for (const FrameRecord& frame : held_out)
          CheckCamera(frame, site.cameras, "the site config");
        const auto held_out_truth = ReadTum(context.Input("held_out_truth"));
        ReadCameraMasks(data_root, &site);
        auto sequences = ReadQuerySequences(site, data_root);
        ReportTruthsApart(sequences, context.Report());
        context.BeginPart("inspect");
        const auto cameras = FindPictureCameras(site, data_root, options, &sequences);
        HashCache files(context.FinalPath("list").replace_filename("hashes.csv"), data_root);
        InspectFrames(
            cameras, data_root, files, context.GetProgress(), context.NumThreads(), &sequences);
        files.Save();
        const QueryLists lists =
            RunQueries(held_out, held_out_truth, sequences, site.sequences.size());
        for (const std::string& reason : lists.skipped) context.Skip(reason);
        context.BeginPart("write");
        WriteQueries(cameras, lists, context);
      });
}
