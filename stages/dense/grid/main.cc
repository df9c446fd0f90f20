// SPDX-License-Identifier: Apache-2.0
// grid: projects the octree to a 2-D occupancy grid per floor. Reads map.ot and, where given,
// keyframes.tum; writes floors.json, the file pair of ROS map_server for each floor, and
// distances.h5.
#include <spdlog/spdlog.h>

#include "pipeline/dense/octree_reader.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/dense/grid/grid.h"
#include "stages/dense/grid/write_grid.h"

namespace {

using namespace nightmap;

std::vector<Eigen::Vector3d> ReadCameras(const StageContext& context) {
  std::vector<Eigen::Vector3d> cameras_in_map;
  if (!context.HasInput("keyframes")) return cameras_in_map;
  for (const StampedPose& keyframe : ReadPoses(context.Input("keyframes"))) {
    cameras_in_map.push_back(keyframe.pose.translation);
  }
  return cameras_in_map;
}

void Run(const GridOptions& options, StageContext& context) {
  context.BeginPart("read");
  const LeafSource leaves = LeavesOfFile(context.Input("octree"));
  const auto cameras_in_map = ReadCameras(context);
  context.BeginPart("project");
  const GridResult result =
      RunGrid(options, leaves, cameras_in_map, context.GetProgress(), context.NumThreads());
  for (const FloorGrid& floor : result.floors) spdlog::info("floor at {:.2f} m", floor.height_m);
  if (result.below_lowest_share > 0.5) {
    spdlog::warn(
        "{:.0f} % of the octree lie below z = 0, which is no floor then: see map_frame's log",
        100 * result.below_lowest_share);
  }
  context.BeginPart("write");
  WriteGrids(result, context);
  context.Report() = DescribeGrids(result);
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{
      "grid",
      "projects the octree to a 2-D occupancy grid for each floor",
      {{"octree", "map.ot of the octree stage"},
       {"keyframes", "keyframes.tum: poses of the camera", Arity::kOptional}},
      {{"floors", "floors.json: lists the floors and their files next to it"},
       {"pgm", "grid of the floor at z = 0: 254 free, 0 occupied, 205 unknown"},
       {"yaml", "map_server's description of that image"},
       {"png", "the grid as a picture; every other floor gets one too", Arity::kOptional},
       {"distances",
        "distances.h5: clearance and signed distance of each floor",
        Arity::kOptional}}};
  return StageMain(argc, argv, spec, GridOptions{}, Run);
}
