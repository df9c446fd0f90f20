// SPDX-License-Identifier: Apache-2.0
// The regions of a site, and for each the observers that see it with their features there: work on
// many points of a night that needs few of them in memory.
#pragma once

#include <vector>

#include "pipeline/camera/landmark_tracker.h"
#include "pipeline/geometry/rectangle.h"
#include "pipeline/io/site_features.h"

namespace nightmap {

// A described frame with a pose.
struct PosedFrame {
  const FrameRecord* frame = nullptr;
  const RgbdCamera* camera = nullptr;
  Rigid3 map_from_camera;
};

struct RegionOptions {
  // A region with more is cut. A few such regions are in memory at a time.
  std::size_t max_observers = 1000;
  // Beyond a region's box. Tracks in the box and in the voxels around it grow as if there were no
  // region where this is three voxels.
  double margin_m = 0.75;
  Eigen::Matrix<double, 2, 3> plane_from_map = Eigen::Matrix<double, 2, 3>::Identity();
};

struct SiteRegion {
  Rectangle box;
  std::size_t num_observers = 0;  // whose position lies in the box
  std::vector<int> seen_by;       // observers that may have features in or near the box, ascending
};

// Regions that partition the plane. One region: all observers see it; no features are read.
std::vector<SiteRegion> CutSite(const RegionOptions& options,
                                const SiteFeatures& features,
                                const std::vector<PosedFrame>& observers,
                                int num_threads);

// Observers in order of time, with copies of their features whose points lie in a region or near
// it, and of those without depth. Observers without any such point are left out.
struct RegionObservers {
  // By observer, without scales and raw_keypoints_px.
  std::vector<FrameFeatures> features;
  std::vector<std::vector<int>> feature_idxs;  // of each feature, among all of its frame
  std::vector<int> observer_idxs;              // of each observer, among those of the site
  std::vector<Observer> observers;             // refer to `features`
};

RegionObservers ReadRegionObservers(const RegionOptions& options,
                                    const SiteFeatures& features,
                                    const std::vector<PosedFrame>& observers,
                                    const SiteRegion& region);

}  // namespace nightmap
