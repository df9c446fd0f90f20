// SPDX-License-Identifier: Apache-2.0
// scan_localize: reads the grid of a floor, scans to locate and, where there are, objects; writes
// queries.csv (every query with its verdict), candidates.csv and the poses of the located scans.
#include <spdlog/spdlog.h>

#include <opencv2/core.hpp>

#include "pipeline/plan/floors_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/laser/scan_localize/located_output.h"

namespace nightmap {
namespace {

std::vector<MapObject> ReadUsedObjects(const ScanLocalizeOptions& options, StageContext& context) {
  if (!context.HasInput("objects")) return {};
  std::vector<MapObject> objects = ReadObjects(context.Input("objects"));
  for (const std::string& notice : ClampObjects(options.max_object_size_m, &objects)) {
    spdlog::warn("{}: {}", context.Input("objects").string(), notice);
  }
  return objects;
}

void Run(const ScanLocalizeOptions& options, StageContext& context) {
  context.BeginPart("read");
  const auto floors = ReadFloors(context.Input("grid"));
  const FloorFiles& floor = floors[*FindFloor(floors, 0)];
  const ScanLocalizeInput input{ReadFloorGrid(context, "grid", floor),
                                ReadScanQueries(context.Input("queries")),
                                ReadUsedObjects(options, context)};
  context.BeginPart("locate");
  const auto located = RunScanLocalize(options, input, context.GetProgress(), context.NumThreads());
  context.BeginPart("write");
  WriteLocated(located, context);
  context.Report()["num_objects"] = input.objects.size();
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "scan_localize",
      "finds where in the map laser scans were taken",
      {{"grid", "floors.json of the grid stage, or an imported map.yaml"},
       {"queries", "queries.h5: the scans"},
       {"objects",
        "objects.yaml: unchanging places",
        Arity::kOptional,
        PortKind::kFile,
        [](const std::filesystem::path& file, const PortPaths&) { ReadObjects(file); }}},
      {{"queries", "queries.csv: every query with the verdict and its reason"},
       {"trajectory", "queries.tum: map_from_robot of the located scans"},
       {"candidates", "candidates.csv: every place that was considered"},
       {"object_poses", "object_poses.csv: where the method published sees objects in the scans"}}};
  cv::setNumThreads(1);  // queries are the unit of parallelism
  return StageMain(argc, argv, spec, ScanLocalizeOptions{}, Run);
}
