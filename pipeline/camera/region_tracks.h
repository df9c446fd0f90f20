// SPDX-License-Identifier: Apache-2.0
// Landmarks under construction, of one region of a site.
#pragma once

#include <vector>

#include "pipeline/camera/region_observers.h"

namespace nightmap {

// Features, by observer of the site, that show a point of an earlier region.
class TakenFeatures {
 public:
  explicit TakenFeatures(std::size_t num_observers) : is_taken_(num_observers) {}
  bool IsTaken(const Sighting& in_site) const;
  void Take(const Sighting& in_site);

 private:
  std::vector<std::vector<bool>> is_taken_;
};

struct RegionTracks {
  RegionObservers seen;
  std::vector<LandmarkTrack> tracks;  // frame_idx counts the observers of the region

  // A sighting of a track by its numbers in the site: frame_idx counts the observers of the site.
  Sighting InSite(const Sighting& sighting) const;
};

// Independent of other regions.
RegionTracks TrackRegion(const RegionOptions& options,
                         const LandmarkTrackerOptions& tracker_options,
                         const SiteFeatures& features,
                         const std::vector<PosedFrame>& observers,
                         const SiteRegion& region);

}  // namespace nightmap
