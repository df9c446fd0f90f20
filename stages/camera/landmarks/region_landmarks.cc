// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/region_landmarks.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "pipeline/base/parallel.h"

namespace nightmap {
std::vector<Landmark> FinishRegion(const LandmarksOptions& options,
                                   DescriptorKind kind,
                                   const Rectangle& box,
                                   const RegionTracks& region,
                                   int num_threads,
                                   TakenFeatures* taken) {
  const auto finish = [&](const LandmarkTrack& track) {
    auto landmark = LandmarkOfTrack(options, kind, region.seen.observers, track);
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
      return taken->IsTaken(region.InSite(sighting));
    });
    if (2 * left.sightings.size() <= landmark->sightings.size()) continue;
    if (left.sightings.size() < landmark->sightings.size()) landmark = finish(left);
    if (!landmark) continue;
    for (const Sighting& sighting : landmark->sightings) taken->Take(region.InSite(sighting));
    landmarks.push_back(std::move(*landmark));
  }
  return landmarks;
}

}  // namespace nightmap
