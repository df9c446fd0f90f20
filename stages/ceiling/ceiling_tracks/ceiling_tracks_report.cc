// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_tracks/ceiling_tracks_report.h"

#include <algorithm>
#include <map>

#include "pipeline/base/median.h"

namespace nightmap {

nlohmann::json CeilingTracksReport(const CeilingTracksResult& result) {
  std::map<std::int64_t, int> lengths;
  std::vector<float> displacements_px;
  int num_sightings = 0, num_redetected = 0, num_empty = 0;
  for (const TrackedFrame& frame : result.tracks.frames) {
    bool is_followed = false;
    for (const CornerSighting& sighting : frame.sightings) {
      is_followed = ++lengths[sighting.track_id] > 1 || is_followed;
    }
    if (is_followed) displacements_px.push_back(frame.median_displacement_px.norm());
    num_sightings += static_cast<int>(frame.sightings.size());
    num_redetected += frame.is_redetected;
    num_empty += frame.sightings.empty();
  }
  std::vector<int> all_lengths;
  for (const auto& [id, length] : lengths) all_lengths.push_back(length);
  const auto ended = [&](TrackEnd reason) {
    return result.num_ended[static_cast<std::size_t>(reason)];
  };
  return {{"num_frames", result.tracks.frames.size()},
          {"num_frames_without_tracks", num_empty},
          {"num_frames_redetected", num_redetected},
          {"num_tracks", lengths.size()},
          {"num_sightings", num_sightings},
          {"num_ended",
           {{"at_border", ended(TrackEnd::kBorder)},
            {"lost", ended(TrackEnd::kLost)},
            {"backward_check", ended(TrackEnd::kBackward)},
            {"off_corner", ended(TrackEnd::kOffCorner)},
            {"merged", ended(TrackEnd::kMerged)},
            {"new_picture", ended(TrackEnd::kNewPicture)}}},
          {"median_length_frames", Median(all_lengths)},
          {"median_displacement_px", Median(displacements_px)}};
}

}  // namespace nightmap
