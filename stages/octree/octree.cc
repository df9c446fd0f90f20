// SPDX-License-Identifier: Apache-2.0
#include "stages/octree/octree.h"

#include <cmath>
#include <limits>
#include <optional>

#include "pipeline/base/error.h"
#include "stages/octree/occupancy_volume.h"
#include "stages/octree/scan.h"

namespace nightmap {
namespace {

float LogOdds(double probability) {
  return static_cast<float>(std::log(probability / (1 - probability)));
}

SensorModel MakeModel(const OctreeOptions& options) {
  return {LogOdds(options.probability_hit),
          LogOdds(options.probability_miss),
          LogOdds(options.probability_min),
          LogOdds(options.probability_max)};
}

// The voxels of the cloud and the 26 around each.
VoxelSupport MakeSupport(const std::vector<CloudPoint>& cloud, double resolution_m) {
  VoxelSupport support;
  for (const CloudPoint& point : cloud) {
    const VoxelKey voxel = VoxelOf(point.position_in_map.cast<double>(), resolution_m);
    for (int i = 0; i < 27; ++i) {
      const VoxelKey near = voxel + VoxelKey(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
      support.At(BlockOf(near)).set(IndexInBlock(near));
    }
  }
  return support;
}

void CheckCloudReach(const std::vector<CloudPoint>& cloud, double reach_m) {
  for (const CloudPoint& point : cloud) {
    if (!(point.position_in_map.cwiseAbs().maxCoeff() < reach_m)) {
      throw DataError(
          "the cloud has a point beyond the octree's reach of {} m; cloud and keyframes must "
          "be of one run, or take a larger octree.resolution_m",
          reach_m);
    }
  }
}

std::vector<ScanPoint> ToScan(const std::vector<DepthPoint>& points,
                              const Rigid3& map_from_camera,
                              double margin_sigmas) {
  std::vector<ScanPoint> scan;
  scan.reserve(points.size());
  for (const DepthPoint& point : points) {
    scan.push_back({map_from_camera * point.point_in_camera.cast<double>(),
                    margin_sigmas * point.sigma_m,
                    point.rgb});
  }
  return scan;
}

OccupancyTree FuseAll(const OctreeOptions& options,
                      const KeyframeSource& source,
                      const VoxelSupport* support,
                      Progress& progress,
                      int num_threads,
                      OctreeResult& result) {
  const std::vector<RayTable> rays = MakeRayTables(source.cameras, num_threads);
  const ScanOptions scan_options{options.resolution_m, options.max_range_m, options.discretize};
  constexpr double kAnyDepth = std::numeric_limits<double>::max();
  OccupancyVolume volume(MakeModel(options));
  result.skipped = FuseKeyframes<ScanEvidence>(
      source,
      progress,
      num_threads,
      [&](const Keyframe& keyframe, const RgbdImages& images) {
        const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
        const auto points = BackProjectDepth(images.depth,
                                             images.color,
                                             rays[camera],
                                             source.cameras[camera],
                                             kAnyDepth,
                                             options.depth_filter);
        const Rigid3& pose = keyframe.map_from_camera;
        return TraceScan(pose.translation,
                         ToScan(points, pose, options.carve_margin_sigmas),
                         scan_options,
                         support);
      },
      [&](ScanEvidence&& evidence) {
        volume.Integrate(evidence);
        result.num_rays += evidence.num_rays;
        result.num_unsupported += evidence.num_unsupported;
      });
  return volume.Leaves(options.resolution_m);
}

void CountVoxels(OctreeResult& result) {
  for (const OccupancyVoxel& leaf : result.tree.leaves) {
    const long edge = std::lround(leaf.size_m / result.tree.resolution_m);
    (leaf.Occupied() ? result.num_occupied : result.num_free) +=
        static_cast<std::size_t>(edge * edge * edge);
  }
}

void CheckOccupied(const OctreeResult& result, const KeyframeSource& source) {
  if (result.num_occupied > 0) return;
  throw DataError(
      "nothing is occupied after {} keyframes ({} unreadable, {} rays, {} points away from "
      "the cloud); check depth_units_per_m of the site's cameras, raise octree.max_range_m, "
      "or set octree.require_cloud_support = false",
      source.keyframes.size(),
      result.skipped.size(),
      result.num_rays,
      result.num_unsupported);
}

}  // namespace

void OctreeOptions::Register(OptionList& list) {
  list.Add("keyframe_stride", &keyframe_stride, Range(1, 1000), "uses every Nth keyframe");
  list.Add("resolution_m", &resolution_m, Range(0.005, 1.0), "edge of the smallest voxel");
  list.Add("max_range_m",
           &max_range_m,
           Range(0.1, 100.0),
           "rays are cut here; what lies beyond is not marked occupied");
  depth_filter.Register(list);
  list.Add("discretize", &discretize, "one ray for all pixels of a frame that end in one voxel");
  list.Add("require_cloud_support",
           &require_cloud_support,
           "ignores depth with no point of the cloud in its voxel or a neighbour");
  list.Add("carve_margin_sigmas",
           &carve_margin_sigmas,
           Range(0.0, 10.0),
           "space this many sigma of depth noise before a hit is not declared free");
  list.Add("probability_hit", &probability_hit, Range(0.501, 0.999), "of occupied, given a hit");
  list.Add("probability_miss", &probability_miss, Range(0.001, 0.499), "of occupied, given a pass");
  list.Add("probability_min", &probability_min, Range(0.0001, 0.499), "lower clamp");
  list.Add("probability_max", &probability_max, Range(0.501, 0.9999), "upper clamp");
  list.Add("max_failed_ratio",
           &max_failed_ratio,
           Range(0.0, 1.0),
           "share of unreadable keyframes above which the stage fails");
}

OctreeResult RunOctree(const OctreeOptions& options,
                       const KeyframeSource& source,
                       const std::vector<CloudPoint>* cloud,
                       Progress& progress,
                       int num_threads) {
  // A voxel of room at the rim for the neighbours of what is seen there.
  const double reach_m = OctreeReach_m(options.resolution_m) - 2 * options.resolution_m;
  CheckReach(source.keyframes, options.max_range_m, reach_m);
  std::optional<VoxelSupport> support;
  if (cloud != nullptr && options.require_cloud_support) {
    CheckCloudReach(*cloud, reach_m);
    support = MakeSupport(*cloud, options.resolution_m);
  }
  OctreeResult result;
  result.tree =
      FuseAll(options, source, support ? &*support : nullptr, progress, num_threads, result);
  CountVoxels(result);
  CheckOccupied(result, source);
  return result;
}

}  // namespace nightmap
