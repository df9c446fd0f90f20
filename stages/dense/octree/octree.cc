// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/octree.h"

#include <cmath>
#include <limits>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/geometry/log_odds.h"
#include "stages/dense/octree/block_colors.h"
#include "stages/dense/octree/keyframe_rays.h"
#include "stages/dense/octree/occupancy_volume.h"
#include "stages/dense/octree/octomap_volume.h"

namespace nightmap {
namespace {

SensorModel MakeModel(const OctreeOptions& options) {
  return {LogOdds(options.probability_hit),
          LogOdds(options.probability_miss),
          LogOdds(options.probability_min),
          LogOdds(options.probability_max),
          LogOdds(options.occupancy_threshold),
          options.min_keyframes};
}

// Input of both builders.
struct Job {
  const OctreeOptions& options;
  const KeyframeSource& source;
  const CloudSupport* support;
  TraceOptions trace;
  std::vector<RayTable> ray_tables;
};

SupportedRays LoadRays(const Job& job, const Keyframe& keyframe, const RgbdImages& images) {
  const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
  constexpr double kAnyDepth = std::numeric_limits<double>::max();
  const auto points = BackProjectDepth(images.depth,
                                       images.color,
                                       job.ray_tables[camera],
                                       job.source.cameras[camera],
                                       kAnyDepth,
                                       job.options.depth_filter);
  return MakeKeyframeRays(points,
                          keyframe.map_from_camera,
                          job.options.carve_margin_sigmas,
                          job.options.max_range_m,
                          job.support);
}

void FuseBatched(const Job& job, Progress& progress, int num_threads, OctreeResult& result) {
  struct Traced {
    KeyframeEvidence evidence;
    std::size_t num_unsupported = 0;
  };
  OccupancyVolume volume(MakeModel(job.options));
  const std::size_t batch = 4 * static_cast<std::size_t>(num_threads);
  std::vector<KeyframeEvidence> pending;
  result.skipped = FuseKeyframes<Traced>(
      job.source,
      progress,
      num_threads,
      [&](const Keyframe& keyframe, const RgbdImages& images) {
        const SupportedRays supported = LoadRays(job, keyframe, images);
        return Traced{TraceRays(supported.rays, job.trace), supported.num_unsupported};
      },
      [&](Traced&& traced) {
        result.num_rays += traced.evidence.num_rays;
        result.num_unsupported += traced.num_unsupported;
        pending.push_back(std::move(traced.evidence));
        if (pending.size() < batch) return;
        volume.Integrate(pending, num_threads);
        pending.clear();
      });
  volume.Integrate(pending, num_threads);
  result.tree = volume.Leaves(job.options.resolution_m, num_threads);
}

void FuseWithOctomap(const Job& job, Progress& progress, int num_threads, OctreeResult& result) {
  OctomapVolume volume(MakeModel(job.options), job.trace);
  result.skipped = FuseKeyframes<SupportedRays>(
      job.source,
      progress,
      num_threads,
      [&](const Keyframe& keyframe, const RgbdImages& images) {
        return LoadRays(job, keyframe, images);
      },
      [&](SupportedRays&& supported) {
        result.num_rays += supported.rays.points.size();
        result.num_unsupported += supported.num_unsupported;
        volume.Insert(supported.rays);
      });
  result.tree = volume.Leaves();
}

// The keyframes whose rays can reach `region`.
KeyframeSource Near(const KeyframeSource& source,
                    const VoxelBox& region,
                    const TraceOptions& trace) {
  const auto edge = [&](const VoxelKey& key, double outwards) {
    return (key.cast<double>() * trace.resolution_m).array() + outwards;
  };
  const double reach_m = trace.max_range_m + trace.resolution_m;
  KeyframeSource near = source;
  std::erase_if(near.keyframes, [&](const Keyframe& keyframe) {
    const auto& position = keyframe.map_from_camera.translation.array();
    return (position < edge(region.min, -reach_m)).any() ||
           (position > edge(region.max, reach_m)).any();
  });
  return near;
}

void CountVoxels(OctreeResult& result) {
  for (const OccupancyVoxel& leaf : result.tree.leaves) {
    const long edge = std::lround(leaf.size_m / result.tree.resolution_m);
    (leaf.Occupied() ? result.num_occupied : result.num_free) +=
        static_cast<std::size_t>(edge * edge * edge);
  }
}

void CheckThreshold(const OctreeOptions& options) {
  const double threshold = options.occupancy_threshold;
  if (threshold > options.probability_min && threshold <= options.probability_max) return;
  throw UsageError(
      "occupancy_threshold {} is not above probability_min {} and at most probability_max {}, so "
      "that nothing can be free, or nothing occupied; change one of them",
      threshold,
      options.probability_min,
      options.probability_max);
}

void CheckAnyOccupied(const OctreeResult& result, const KeyframeSource& source) {
  if (result.num_occupied > 0) return;
  throw DataError(
      "nothing is occupied after {} keyframes ({} unreadable, {} rays, {} points away from "
      "the cloud); check depth_units_per_m of the site's cameras, raise octree.max_range_m, lower "
      "octree.occupancy_threshold or min_keyframes, or set octree.require_cloud_support = false",
      source.keyframes.size(),
      result.skipped.size(),
      result.num_rays,
      result.num_unsupported);
}

}  // namespace

OctreeResult RunOctree(const OctreeOptions& options,
                       const KeyframeSource& source,
                       const std::vector<CloudPoint>* cloud,
                       const std::optional<VoxelBox>& region,
                       Progress& progress,
                       int num_threads) {
  CheckThreshold(options);
  // Keeps a voxel free at the rim for the neighbours of seen voxels.
  const double reach_m = OctreeReach_m(options.resolution_m) - 2 * options.resolution_m;
  CheckReach(source.keyframes, options.max_range_m, reach_m);
  std::optional<CloudSupport> support;
  if (cloud != nullptr && options.require_cloud_support) {
    support.emplace(*cloud, options.resolution_m, reach_m);
  }
  const TraceOptions trace{options.resolution_m, options.max_range_m, options.discretize, region};
  const KeyframeSource used = region ? Near(source, *region, trace) : source;
  const Job job{options,
                used,
                support ? &*support : nullptr,
                trace,
                MakeRayTables(used.cameras, num_threads)};
  OctreeResult result;
  const auto fuse = options.builder == "octomap" ? FuseWithOctomap : FuseBatched;
  fuse(job, progress, num_threads, result);
  CountVoxels(result);
  if (!region) CheckAnyOccupied(result, source);
  return result;
}

}  // namespace nightmap
