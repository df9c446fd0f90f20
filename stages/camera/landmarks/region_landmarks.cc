// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/region_landmarks.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

// A feature of a region, by its numbers in the site.
Sighting InSite(const RegionObservers& seen, const Sighting& sighting) {
  const auto observer = static_cast<std::size_t>(sighting.frame_idx);
  const auto feature = static_cast<std::size_t>(sighting.feature_idx);
  return {seen.observer_idxs[observer], seen.feature_idxs[observer][feature]};
}

}  // namespace

bool TakenFeatures::IsTaken(int observer_idx, int feature_idx) const {
  const auto& of_observer = is_taken_[static_cast<std::size_t>(observer_idx)];
  const auto feature = static_cast<std::size_t>(feature_idx);
  return feature < of_observer.size() && of_observer[feature];
}

void TakenFeatures::Take(int observer_idx, int feature_idx) {
  auto& of_observer = is_taken_[static_cast<std::size_t>(observer_idx)];
  const auto feature = static_cast<std::size_t>(feature_idx);
  if (feature >= of_observer.size()) of_observer.resize(feature + 1, false);
  of_observer[feature] = true;
}

RegionTracks TrackRegion(const LandmarksOptions& options,
                         const LandmarksInput& input,
                         const std::vector<PosedFrame>& observers,
                         const SiteRegion& region,
                         Progress& progress) {
  RegionTracks result{ReadRegionObservers(options, input, observers, region), {}};
  const auto& seen_by = result.seen.observers;
  progress.Advance(region.seen_by.size() - seen_by.size());
  LandmarkTracker tracker(options.tracker, input.features.Heads().kind, &seen_by);
  for (std::size_t i = 0; i < seen_by.size(); ++i) {
    tracker.Add(static_cast<int>(i));
    progress.Advance();
  }
  result.tracks = tracker.TakeTracks();
  return result;
}

std::vector<Landmark> FinishRegion(const LandmarksOptions& options,
                                   DescriptorKind kind,
                                   const Rectangle& box,
                                   const RegionTracks& region,
                                   int num_threads,
                                   TakenFeatures* taken) {
  const RegionObservers& seen = region.seen;
  const auto finish = [&](const LandmarkTrack& track) {
    auto landmark = LandmarkOfTrack(options, kind, seen.observers, track);
    if (landmark && !box.Contains(landmark->position_in_map.head<2>())) landmark.reset();
    return landmark;
  };
  std::vector<std::optional<Landmark>> finished(region.tracks.size());
  ParallelFor(
      finished.size(), num_threads, [&](std::size_t i) { finished[i] = finish(region.tracks[i]); });
  std::vector<Landmark> landmarks;
  for (auto& landmark : finished) {
    if (!landmark) continue;
    LandmarkTrack left{landmark->position_in_map, {}, landmark->sightings};
    std::erase_if(left.sightings, [&](const Sighting& sighting) {
      const Sighting in_site = InSite(seen, sighting);
      return taken->IsTaken(in_site.frame_idx, in_site.feature_idx);
    });
    if (2 * left.sightings.size() <= landmark->sightings.size()) continue;
    if (left.sightings.size() < landmark->sightings.size()) landmark = finish(left);
    if (!landmark) continue;
    for (const Sighting& sighting : landmark->sightings) {
      const Sighting in_site = InSite(seen, sighting);
      taken->Take(in_site.frame_idx, in_site.feature_idx);
    }
    landmarks.push_back(std::move(*landmark));
  }
  return landmarks;
}

}  // namespace nightmap
