// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/region_observers.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/trajectory_io.h"
#include "stages/camera/landmarks/plane_cells.h"

namespace nightmap {
namespace {

// The smallest rectangle around points; empty without any.
struct PointBounds {
  Eigen::Vector2d min_m = Eigen::Vector2d::Constant(Rectangle::kUnbounded);
  Eigen::Vector2d max_m = Eigen::Vector2d::Constant(-Rectangle::kUnbounded);

  bool Meets(const Rectangle& box) const {
    return min_m.x() <= max_m.x() && box.Touches(min_m, max_m);
  }
};

Observer WithFeatures(const PosedFrame& posed, const FrameFeatures* features) {
  return {posed.frame, posed.camera, features, posed.map_from_camera};
}

PointBounds BoundsOf(const PosedFrame& posed, const FrameFeatures& features) {
  const Observer observer = WithFeatures(posed, &features);
  PointBounds bounds;
  for (int i = 0; i < features.NumFeatures(); ++i) {
    if (features.Feature(i).Depth_m() <= 0) continue;
    const Eigen::Vector2d point = FeatureInMap(observer, i).head<2>();
    bounds.min_m = bounds.min_m.cwiseMin(point);
    bounds.max_m = bounds.max_m.cwiseMax(point);
  }
  return bounds;
}

// One pass over the shards.
std::vector<PointBounds> BoundsOfAll(const SiteFeatures& features,
                                     const std::vector<PosedFrame>& observers,
                                     int num_threads) {
  const int first_frame = features.FirstFrame();
  std::vector<int> observer_of(features.Heads().frames.size(), -1);
  for (std::size_t i = 0; i < observers.size(); ++i) {
    observer_of[static_cast<std::size_t>(observers[i].frame->frame_idx - first_frame)] =
        static_cast<int>(i);
  }
  std::vector<PointBounds> bounds(observers.size());
  for (std::size_t shard = 0; shard < features.NumShards(); ++shard) {
    const SiteFeatures::Shard of_shard = features.GetShard(shard);
    ParallelFor(of_shard->frames.size(), num_threads, [&](std::size_t i) {
      const FrameFeatures& frame = of_shard->frames[i];
      const int observer = observer_of[static_cast<std::size_t>(frame.frame_idx - first_frame)];
      if (observer < 0) return;
      const auto k = static_cast<std::size_t>(observer);
      bounds[k] = BoundsOf(observers[k], frame);
    });
  }
  return bounds;
}

// Beyond a region's box. Tracks in the box and in the voxels around it then grow as if there were
// no region.
double Margin_m(const LandmarksOptions& options) { return 3 * options.tracker.voxel_size_m; }

std::vector<int> AllOf(std::size_t count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// Copies the features that are in the box or have no depth. Returns whether any point is in the
// box.
bool CopyFeatures(const PosedFrame& posed,
                  const FrameFeatures& all,
                  const Rectangle& box,
                  DescriptorKind kind,
                  FrameFeatures* features,
                  std::vector<int>* feature_idxs) {
  const Observer observer = WithFeatures(posed, &all);
  const int size = DescriptorSize(kind);
  bool is_seen = false;
  features->frame_idx = all.frame_idx;
  for (int i = 0; i < all.NumFeatures(); ++i) {
    const FeatureView feature = all.Feature(i);
    if (feature.Depth_m() > 0) {
      if (!box.Contains(FeatureInMap(observer, i).head<2>())) continue;
      is_seen = true;
    }
    features->keypoints_px.push_back(all.keypoints_px[static_cast<std::size_t>(i)]);
    features->depths_m.push_back(all.depths_m[static_cast<std::size_t>(i)]);
    const std::uint8_t* descriptor = feature.Descriptor(kind);
    features->descriptors.insert(features->descriptors.end(), descriptor, descriptor + size);
    feature_idxs->push_back(i);
  }
  return is_seen;
}

}  // namespace

std::vector<PosedFrame> FindObservers(const LandmarksOptions& options,
                                      const LandmarksInput& input) {
  const bool are_all = options.observers == "all";
  const auto& poses = are_all ? input.trajectory : input.keyframes;
  std::vector<PosedFrame> observers;
  std::size_t num_found = 0;
  for (std::size_t i = 0; i < input.frames.size(); ++i) {
    const FrameRecord& frame = input.frames[i];
    const int pose = FindPose(poses, frame.time_ns);
    num_found += pose >= 0;
    if (pose < 0 || !input.features.Heads().frames[i].IsDescribed()) continue;
    observers.push_back({&frame,
                         &input.cameras.at(static_cast<std::size_t>(frame.camera_idx)),
                         poses[static_cast<std::size_t>(pose)].pose});
  }
  if (num_found != poses.size()) {
    throw InputError(
        {{are_all ? "trajectory" : "keyframes"}, {"frames"}},
        "{} of {} poses have the time of no frame; a file is damaged or another site's",
        poses.size() - num_found,
        poses.size());
  }
  std::ranges::stable_sort(observers, {}, [](const PosedFrame& o) { return o.frame->time_ns; });
  return observers;
}

std::vector<SiteRegion> CutSite(const LandmarksOptions& options,
                                const LandmarksInput& input,
                                const std::vector<PosedFrame>& observers,
                                int num_threads) {
  const double margin_m = Margin_m(options);
  std::vector<Eigen::Vector2d> positions;
  for (const PosedFrame& observer : observers) {
    positions.push_back(observer.map_from_camera.translation.head<2>());
  }
  std::vector<SiteRegion> regions;
  for (const PlaneCell& cell :
       CutPlane(std::move(positions), input.max_region_observers, 2 * margin_m)) {
    regions.push_back({cell.box, cell.num_positions, {}});
  }
  if (regions.size() == 1) {
    regions[0].seen_by = AllOf(observers.size());
    return regions;
  }
  const auto bounds = BoundsOfAll(input.features, observers, num_threads);
  ParallelFor(regions.size(), num_threads, [&](std::size_t i) {
    const Rectangle box = regions[i].box.Grown(margin_m);
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      if (bounds[k].Meets(box)) regions[i].seen_by.push_back(static_cast<int>(k));
    }
  });
  return regions;
}

RegionObservers ReadRegionObservers(const LandmarksOptions& options,
                                    const LandmarksInput& input,
                                    const std::vector<PosedFrame>& observers,
                                    const SiteRegion& region) {
  const Rectangle box = region.box.Grown(Margin_m(options));
  const DescriptorKind kind = input.features.Heads().kind;
  RegionObservers read;
  for (const int observer_idx : region.seen_by) {
    const PosedFrame& posed = observers[static_cast<std::size_t>(observer_idx)];
    const SiteFeatures::Frame all = input.features.GetFrame(posed.frame->frame_idx);
    FrameFeatures features;
    std::vector<int> feature_idxs;
    if (!CopyFeatures(posed, *all, box, kind, &features, &feature_idxs)) continue;
    read.features.push_back(std::move(features));
    read.feature_idxs.push_back(std::move(feature_idxs));
    read.observer_idxs.push_back(observer_idx);
  }
  for (std::size_t i = 0; i < read.features.size(); ++i) {
    const PosedFrame& posed = observers[static_cast<std::size_t>(read.observer_idxs[i])];
    read.observers.push_back(WithFeatures(posed, &read.features[i]));
  }
  return read;
}

}  // namespace nightmap
