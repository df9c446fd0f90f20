// SPDX-License-Identifier: Apache-2.0
// frames: lists a site's frames and the measurements of its other sensors. Reads a site config and
// the raw recordings; writes shards.txt and, next to it, shard_NNNN.csv, cameras.json,
// held_out.csv, the truth, and acceleration.h5, odometry.h5, scans.h5.
#include "pipeline/program/stage_main.h"
#include "pipeline/recording/camera_masks.h"
#include "pipeline/recording/inspect_frames.h"
#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/read_signals.h"
#include "pipeline/recording/site_config.h"
#include "pipeline/recording/truths_apart.h"
#include "stages/recording/frames/frames.h"
#include "stages/recording/frames/robot_truth.h"
#include "stages/recording/frames/write_frames.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "frames",
      "lists, checks and associates the frames and signals of a site",
      {CheckedPort("site", "site config, configs/sites/<site>.toml", CheckSiteConfig),
       FolderPort("data", "folder of the recordings")},
      {{"shards", "shards.txt; the other files are written next to it"}}};
  return StageMain(
      argc, argv, spec, FramesOptions{}, [](const FramesOptions& options, StageContext& context) {
        const auto& data_root = context.Input("data");
        SiteConfig site = ReadSiteConfig(context.Input("site"));
        context.BeginPart("list");
        auto sequences = ReadSequences(site, data_root);
        ReportTruthsApart(sequences, context.Report());
        CheckAreas(site.cameras, options.max_picture_mpx);
        ReadCameraMasks(data_root, &site);
        ReportLeftOut(options, SelectFrames(options, &sequences), context.Report());
        context.BeginPart("signals");
        auto [signals, problems, num_in_line_order, found_in_scans, apart] =
            ReadSensorSignals(site, data_root, options.max_failed_ratio);
        ReportTimesInLineOrder(site, num_in_line_order, context.Report());
        ReportFoundInScans(site, found_in_scans, context.Report());
        ReportApart(apart, context.Report());
        const RobotTruth robot_truth = TakeRobotTruth(site, data_root, &signals);
        context.BeginPart("inspect");
        HashCache files(context.FinalPath("shards").replace_filename("hashes.csv"), data_root);
        InspectFrames(site.cameras,
                      data_root,
                      files,
                      context.GetProgress(),
                      context.NumThreads(),
                      &sequences);
        files.Save();
        const FrameLists lists = RunFrames(sequences, site.hold_out_every);
        ReportSkipped(options, lists, problems, context);
        if (!sequences.empty()) CheckAnyIsLeft(lists, data_root);
        context.BeginPart("write");
        WriteFrames(options, site.cameras, lists, signals, robot_truth, context);
      });
}
