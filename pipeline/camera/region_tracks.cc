// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/region_tracks.h"

namespace nightmap {

bool TakenFeatures::IsTaken(const Sighting& in_site) const {
  const auto& of_observer = is_taken_[static_cast<std::size_t>(in_site.frame_idx)];
  const auto feature = static_cast<std::size_t>(in_site.feature_idx);
  return feature < of_observer.size() && of_observer[feature];
}

void TakenFeatures::Take(const Sighting& in_site) {
  auto& of_observer = is_taken_[static_cast<std::size_t>(in_site.frame_idx)];
  const auto feature = static_cast<std::size_t>(in_site.feature_idx);
  if (feature >= of_observer.size()) of_observer.resize(feature + 1, false);
  of_observer[feature] = true;
}

Sighting RegionTracks::InSite(const Sighting& sighting) const {
  const auto observer = static_cast<std::size_t>(sighting.frame_idx);
  const auto feature = static_cast<std::size_t>(sighting.feature_idx);
  return {seen.observer_idxs[observer], seen.feature_idxs[observer][feature]};
}

RegionTracks TrackRegion(const RegionOptions& options,
                         const LandmarkTrackerOptions& tracker_options,
                         const SiteFeatures& features,
                         const std::vector<PosedFrame>& observers,
                         const SiteRegion& region) {
  RegionTracks result{ReadRegionObservers(options, features, observers, region), {}};
  const auto& seen_by = result.seen.observers;
  LandmarkTracker tracker(tracker_options, features.Heads().kind, &seen_by);
  for (std::size_t i = 0; i < seen_by.size(); ++i) tracker.Add(static_cast<int>(i));
  result.tracks = tracker.TakeTracks();
  return result;
}

}  // namespace nightmap
