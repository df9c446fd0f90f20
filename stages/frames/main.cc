// SPDX-License-Identifier: Apache-2.0
// frames: lists a site's RGB-D frames. Reads a site config and the raw recordings; writes
// shards.txt and, beside it, shard_NNNN.csv, cameras.json, queries.csv, query_cameras.json and the
// truth.
#include <spdlog/spdlog.h>

#include "pipeline/base/stage_main.h"
#include "pipeline/io/site_config.h"
#include "stages/frames/frames.h"
#include "stages/frames/inspect_frames.h"
#include "stages/frames/picture_cameras.h"
#include "stages/frames/read_sequence.h"
#include "stages/frames/write_frames.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"frames",
                       "lists, checks and associates the RGB-D frames of a site",
                       {{"site", "site config, configs/sites/<site>.toml"},
                        FolderPort("data", "folder of the recordings")},
                       {{"shards", "shards.txt; the other files are written beside it"}}};
  return StageMain(
      argc, argv, spec, FramesOptions{}, [](const FramesOptions& options, StageContext& context) {
        const auto& data_root = context.Input("data");
        const SiteConfig site = ReadSiteConfig(context.Input("site"));
        context.BeginPart("list");
        auto sequences = ReadSequences(site, data_root);
        const auto accelerations = ReadAccelerations(site, data_root);
        const std::size_t num_left_out = SelectFrames(options, &sequences);
        context.Report()["num_left_out_by_max_frames"] = num_left_out;
        if (num_left_out > 0) {
          spdlog::warn("max_frames = {} leaves out the last {} frames; raise it to map them",
                       options.max_frames,
                       num_left_out);
        }
        context.BeginPart("inspect");
        const auto cameras =
            FindPictureCameras(site, data_root, options.max_picture_mpx, &sequences);
        InspectFrames(cameras, data_root, context.GetProgress(), context.NumThreads(), &sequences);
        const FrameLists lists = RunFrames(sequences, site.hold_out_every);
        for (const std::string& reason : lists.skipped) context.Skip(reason);
        context.CheckSkipped(lists.num_inspected, options.max_failed_ratio);
        if (lists.frames.empty()) {
          throw DataError("{}: no usable frame is left: see the skipped ones above",
                          data_root.string());
        }
        context.BeginPart("write");
        WriteFrames(options, cameras, lists, accelerations, context);
      });
}
