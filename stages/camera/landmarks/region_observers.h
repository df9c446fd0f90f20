// SPDX-License-Identifier: Apache-2.0
// The regions of a site, and for each the observers that see it with their features there.
#pragma once

#include <vector>

#include "pipeline/geometry/rectangle.h"
#include "stages/camera/landmarks/landmarks.h"

namespace nightmap {

// A described frame with a pose.
struct PosedFrame {
  const FrameRecord* frame = nullptr;
  const RgbdCamera* camera = nullptr;
  Rigid3 map_from_camera;
};

// The observers of the site, in order of time. Throws InputError for poses at times that no frame
// has. `input` must outlive the result.
std::vector<PosedFrame> FindObservers(const LandmarksOptions& options, const LandmarksInput& input);

struct SiteRegion {
  Rectangle box;
  std::size_t num_observers = 0;  // whose position lies in the box
  std::vector<int> seen_by;       // observers that may have features in or near the box, ascending
};

// Regions that partition the plane. One region: all observers see it; no features are read.
std::vector<SiteRegion> CutSite(const LandmarksOptions& options,
                                const LandmarksInput& input,
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

RegionObservers ReadRegionObservers(const LandmarksOptions& options,
                                    const LandmarksInput& input,
                                    const std::vector<PosedFrame>& observers,
                                    const SiteRegion& region);

}  // namespace nightmap
