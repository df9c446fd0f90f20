// SPDX-License-Identifier: Apache-2.0
// scan_queries: lists the laser scans to locate. Reads the site config and the logs that its
// [[query]] tables name, also those that QUERY asks for, but no recording. Writes queries.txt and,
// next to it, queries.h5.
#include "stages/laser/scan_queries/scan_queries.h"

#include <spdlog/spdlog.h>

#include "pipeline/io/unit_list.h"
#include "pipeline/program/stage_main.h"
#include "pipeline/recording/site_config.h"
#include "stages/laser/scan_queries/read_logs.h"

namespace nightmap {
namespace {

void Run(const ScanQueriesOptions& options, StageContext& context) {
  SiteConfig site = ReadSiteConfig(context.Input("site"));
  ReadAskedQueries(context.Input("asked"), &site);
  for (const SequenceConfig& pictures : site.queries) {
    spdlog::warn("{}: pictures are not located in a map of laser scans", pictures.source);
  }
  context.BeginPart("list");
  const ScanLogs read = ReadScanLogs(site, context.Input("data"), options.max_failed_ratio);
  for (const std::string& reason : read.problems) context.Skip(reason);
  const auto queries = RunScanQueries(options, read.logs);
  context.BeginPart("write");
  WriteScanQueries(context.OutputBeside("list", "queries.h5"), queries);
  std::vector<std::string> names;
  for (const ScanQuery& query : queries) names.push_back(query.name);
  WriteFile(context.Output("list"), NameListToText("queries", names));
  context.Report()["num_queries"] = queries.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "scan_queries",
      "lists the laser scans to locate in a site's map",
      {CheckedPort("site", "site config, configs/sites/<site>.toml", CheckSiteConfig),
       CheckedPort("asked", "[[query]] tables of QUERY", "site", CheckAskedQueries),
       FolderPort("data", "folder of the recordings")},
      {{"list", "queries.txt; queries.h5 is written next to it"}}};
  return StageMain(argc, argv, spec, ScanQueriesOptions{}, Run);
}
