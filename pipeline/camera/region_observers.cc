// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/region_observers.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/camera/plane_cells.h"

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

PointBounds BoundsOf(const RegionOptions& options,
                     const PosedFrame& posed,
                     const FrameFeatures& features) {
  const Observer observer = WithFeatures(posed, &features);
  PointBounds bounds;
  for (int i = 0; i < features.NumFeatures(); ++i) {
    if (features.Feature(i).Depth_m() <= 0) continue;
    const Eigen::Vector2d point = options.plane_from_map * FeatureInMap(observer, i);
    bounds.min_m = bounds.min_m.cwiseMin(point);
    bounds.max_m = bounds.max_m.cwiseMax(point);
  }
  return bounds;
}

// One pass over the shards.
std::vector<PointBounds> BoundsOfAll(const RegionOptions& options,
                                     const SiteFeatures& features,
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
      bounds[k] = BoundsOf(options, observers[k], frame);
    });
  }
  return bounds;
}

std::vector<int> AllOf(std::size_t count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// Copies the features that are in the box or have no depth. Returns whether any point is in the
// box.
bool CopyFeatures(const RegionOptions& options,
                  const PosedFrame& posed,
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
      if (!box.Contains(options.plane_from_map * FeatureInMap(observer, i))) continue;
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

std::vector<SiteRegion> CutSite(const RegionOptions& options,
                                const SiteFeatures& features,
                                const std::vector<PosedFrame>& observers,
                                int num_threads) {
  std::vector<Eigen::Vector2d> positions;
  for (const PosedFrame& observer : observers) {
    positions.push_back(options.plane_from_map * observer.map_from_camera.translation);
  }
  std::vector<SiteRegion> regions;
  for (const PlaneCell& cell :
       CutPlane(std::move(positions), options.max_observers, 2 * options.margin_m)) {
    regions.push_back({cell.box, cell.num_positions, {}});
  }
  if (regions.size() == 1) {
    regions[0].seen_by = AllOf(observers.size());
    return regions;
  }
  const auto bounds = BoundsOfAll(options, features, observers, num_threads);
  ParallelFor(regions.size(), num_threads, [&](std::size_t i) {
    const Rectangle box = regions[i].box.Grown(options.margin_m);
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      if (bounds[k].Meets(box)) regions[i].seen_by.push_back(static_cast<int>(k));
    }
  });
  return regions;
}

RegionObservers ReadRegionObservers(const RegionOptions& options,
                                    const SiteFeatures& features,
                                    const std::vector<PosedFrame>& observers,
                                    const SiteRegion& region) {
  const Rectangle box = region.box.Grown(options.margin_m);
  const DescriptorKind kind = features.Heads().kind;
  RegionObservers read;
  for (const int observer_idx : region.seen_by) {
    const PosedFrame& posed = observers[static_cast<std::size_t>(observer_idx)];
    const SiteFeatures::Frame all = features.GetFrame(posed.frame->frame_idx);
    FrameFeatures copied;
    std::vector<int> feature_idxs;
    if (!CopyFeatures(options, posed, *all, box, kind, &copied, &feature_idxs)) continue;
    read.features.push_back(std::move(copied));
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
