// SPDX-License-Identifier: Apache-2.0
// Landmarks of one region.
#pragma once

#include <vector>

#include "stages/camera/landmarks/landmark_of_track.h"
#include "stages/camera/landmarks/region_observers.h"

namespace nightmap {

// Features, by observer of the site, that show a landmark of an earlier region.
class TakenFeatures {
 public:
  explicit TakenFeatures(std::size_t num_observers) : is_taken_(num_observers) {}
  bool IsTaken(int observer_idx, int feature_idx) const;
  void Take(int observer_idx, int feature_idx);

 private:
  std::vector<std::vector<bool>> is_taken_;
};

struct RegionTracks {
  RegionObservers seen;
  std::vector<LandmarkTrack> tracks;  // frame_idx counts the observers of the region
};

// Independent of other regions. Advances by the observers that may see the region.
RegionTracks TrackRegion(const LandmarksOptions& options,
                         const LandmarksInput& input,
                         const std::vector<PosedFrame>& observers,
                         const SiteRegion& region,
                         Progress& progress);

// The landmarks that lie in the region's box. Regions take features in their order: two landmarks
// of different regions never share one. A landmark that lost half of its observations or more is
// one of the earlier region, seen again, and is dropped.
std::vector<Landmark> FinishRegion(const LandmarksOptions& options,
                                   DescriptorKind kind,
                                   const Rectangle& box,
                                   const RegionTracks& tracks,
                                   int num_threads,
                                   TakenFeatures* taken);

}  // namespace nightmap
