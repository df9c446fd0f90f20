// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/visit_by_frame.h"

#include <cstdint>
#include <numeric>
#include <utility>

namespace nightmap {

void VisitByFrame(const TrackList& tracks,
                  const SiteFeatures& features,
                  const VisitFeature& visit) {
  using Place = std::pair<std::uint32_t, std::uint32_t>;  // track, and sighting of it
  const int first = features.FirstFrame();
  const auto frame_of = [&](const Sighting& s) {
    return static_cast<std::size_t>(s.frame_idx - first);
  };
  std::vector<std::size_t> begins(features.Heads().frames.size() + 1, 0);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    for (const Sighting& s : tracks[i]) ++begins[frame_of(s) + 1];
  }
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<Place> places(begins.back());
  std::vector<std::size_t> next(begins.begin(), begins.end() - 1);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    for (std::size_t k = 0; k < tracks[i].size(); ++k) {
      places[next[frame_of(tracks[i][k])]++] = {static_cast<std::uint32_t>(i),
                                                static_cast<std::uint32_t>(k)};
    }
  }
  for (std::size_t frame = 0; frame + 1 < begins.size(); ++frame) {
    if (begins[frame] == begins[frame + 1]) continue;
    const SiteFeatures::Frame of_frame = features.GetFrame(first + static_cast<int>(frame));
    for (std::size_t i = begins[frame]; i < begins[frame + 1]; ++i) {
      const auto [track, sighting] = places[i];
      visit(track, sighting, of_frame->Feature(tracks[track][sighting].feature_idx));
    }
  }
}

}  // namespace nightmap
