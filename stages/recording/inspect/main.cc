// SPDX-License-Identifier: Apache-2.0
// inspect: prints a summary of a site's recordings. Reads a site config and the raw recordings,
// writes nothing.
#include "stages/recording/inspect/inspect.h"

#include <iostream>

#include "pipeline/base/plain_text.h"
#include "pipeline/program/stage_main.h"
#include "pipeline/recording/site_config.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"inspect",
                       "prints the contents of a site's recordings: channels, rates, gaps, ranges",
                       {{"site", "site config, configs/sites/<site>.toml"},
                        FolderPort("data", "folder of the recordings")},
                       {}};
  return StageMain(
      argc, argv, spec, InspectOptions{}, [](const InspectOptions& options, StageContext& context) {
        const auto& data_root = context.Input("data");
        const SiteConfig site = ReadSiteConfig(context.Input("site"));
        const auto sequences = ReadSequences(site, data_root);
        for (const RawSequence& sequence : sequences) {
          for (const std::string& left_out : sequence.left_out) context.Skip(left_out);
        }
        const auto [signals, problems, num_in_line_order, found_in_scans, apart] =
            ReadSensorSignals(site, data_root, options.max_failed_ratio);
        for (const std::string& problem : problems) context.Skip(problem);
        for (const std::string& text : apart) context.Skip(text);
        const auto sample = [&](const RawSequence& sequence) {
          return SampledPictures(sequence, site, data_root, options.num_sampled_frames);
        };
        std::cout << AsLines(InspectionText(RunInspect(sequences, signals, sample)));
      });
}
