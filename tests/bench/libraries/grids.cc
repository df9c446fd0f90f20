// SPDX-License-Identifier: Apache-2.0
// The octree's builder against OctoMap's, and the distance transform against OpenCV's.
#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/parallel.h"
#include "pipeline/dense/back_project.h"
#include "pipeline/plan/distance_transform.h"
#include "stages/dense/octree/occupancy_volume.h"
#include "stages/dense/octree/octomap_volume.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"
#include "tests/stages/dense/octree/voxel_states.h"
#include "tests/stages/plan/plan/office_floor.h"

namespace nightmap {
namespace {

constexpr std::size_t kNumKeyframes = 12;

std::vector<KeyframeRays> LoadRays(const MappedSite& site) {
  std::vector<KeyframeRays> all_rays;
  for (const Keyframe& keyframe : EvenlySpaced(site.keyframes.keyframes, kNumKeyframes)) {
    const RgbdImages images = site.keyframes.load(keyframe);
    const RgbdCamera& camera = site.CameraOf(keyframe.frame.frame_idx);
    KeyframeRays& rays = all_rays.emplace_back();
    rays.origin_in_map = keyframe.map_from_camera.translation;
    for (const DepthPoint& point : BackProjectDepth(
             images.depth, images.color, MakeRayTable(camera.color, 1), camera, 4.0, {})) {
      rays.points.push_back(
          {keyframe.map_from_camera * point.point_in_camera.cast<double>(), 0, point.rgb});
    }
  }
  return all_rays;
}

OccupancyTree Batched(const std::vector<KeyframeRays>& all_rays,
                      const TraceOptions& options,
                      int num_threads) {
  OccupancyVolume volume({});
  std::vector<KeyframeEvidence> evidence(all_rays.size());
  ParallelFor(all_rays.size(), num_threads, [&](std::size_t i) {
    evidence[i] = TraceRays(all_rays[i], options);
  });
  volume.Integrate(evidence, num_threads);
  return volume.Leaves(options.resolution_m, num_threads);
}

}  // namespace

void CompareOctrees(const MappedSite& site) {
  const std::vector<KeyframeRays> all_rays = LoadRays(site);
  for (const bool discretize : {false, true}) {
    TraceOptions options;
    options.discretize = discretize;
    OccupancyTree ours;
    std::unique_ptr<OctomapVolume> theirs;
    PrintComparison(
        {.ours = "`OccupancyVolume`",
         .other = std::string("OctoMap's `insertPointCloud`") + (discretize ? ", discretize" : ""),
         .input = fmt::format("{}: depth image, voxels of 5 cm", site.name),
         .run_ours = [&](int num_threads) { ours = Batched(all_rays, options, num_threads); },
         .run_other =
             [&](int) {
               theirs = std::make_unique<OctomapVolume>(SensorModel{}, options);
               for (const KeyframeRays& rays : all_rays) theirs->Insert(rays);
             },
         .difference =
             [&] {
               const VoxelStates a(ours), b(theirs->Leaves());
               return fmt::format("IoU occupied {:.3f}, free {:.3f}",
                                  a.IntersectionOverUnion(b, true),
                                  a.IntersectionOverUnion(b, false));
             },
         .num_items = static_cast<double>(all_rays.size())});
  }
}

void CompareDistanceTransforms() {
  const OccupancyGrid grid = OfficeFloor(1, 100).ToGrid(100, 0.05, 0);
  std::vector<std::uint8_t> blocked;
  for (const std::uint8_t cell : grid.cells) blocked.push_back(cell == kFreeCell ? 0 : 255);
  cv::Mat is_free = 255 - cv::Mat(grid.height, grid.width, CV_8U, blocked.data());
  std::vector<std::int32_t> ours;
  cv::Mat theirs;
  PrintComparison(
      {.ours = "`SquaredDistances`",
       .other = "`cv::distanceTransform`, precise",
       .input = fmt::format("office floor of {} x {} cells", grid.width, grid.height),
       .run_ours =
           [&](int num_threads) {
             ours = SquaredDistances(blocked, grid.width, grid.height, false, num_threads);
           },
       .run_other =
           [&](int) { cv::distanceTransform(is_free, theirs, cv::DIST_L2, cv::DIST_MASK_PRECISE); },
       .difference =
           [&] {
             double largest = 0;
             for (std::size_t i = 0; i < ours.size(); ++i) {
               const double other = theirs.at<float>(static_cast<int>(i) / grid.width,
                                                     static_cast<int>(i) % grid.width);
               largest = std::max(largest, std::abs(std::sqrt(ours[i]) - other));
             }
             return fmt::format("at most {:.2g} cells", largest);
           }});
}

}  // namespace nightmap
