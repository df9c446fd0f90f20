// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/queries/write_queries.h"

#include <filesystem>

#include "pipeline/io/trajectory_io.h"
#include "pipeline/io/unit_list.h"

namespace nightmap {
namespace {

constexpr const char* kList = "list";
constexpr const char* kTruth = "query_ground_truth.tum";

}  // namespace

void WriteQueries(const std::vector<RgbdCamera>& cameras, QueryLists lists, StageContext& context) {
  const auto used = KeepUsedCameras(cameras, &lists.queries);
  WriteFile(context.OutputBeside(kList, "query_cameras.json"), CamerasToJson(used));
  WriteFile(context.OutputBeside(kList, "queries.csv"), FramesToCsv(lists.queries));
  if (lists.ground_truth.empty()) {
    std::filesystem::remove(context.FinalPath(kList).replace_filename(kTruth));
  } else {
    WriteFile(context.OutputBeside(kList, kTruth),
              TrajectoryToTum(lists.ground_truth,
                              "ground truth of the site, world_from_camera, at the times of the "
                              "queries"));
  }
  std::vector<std::string> names;
  for (const FrameRecord& query : lists.queries) names.push_back(query.color.path);
  WriteFile(context.Output(kList), NameListToText("queries", names));
  context.Report()["num_queries"] = lists.queries.size();
  context.Report()["num_queries_with_ground_truth"] = lists.ground_truth.size();
  context.Report()["num_query_cameras"] = used.size();
}

}  // namespace nightmap
