// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/tracks_by_projection.h"

namespace nightmap {

std::vector<Track> TracksByProjection(const AdjustInput& input,
                                      const std::map<int, Rigid3>& graph_from_frame,
                                      const LandmarkTrackerOptions& options) {
  const FeaturesShard all = input.features.All();
  std::vector<Observer> observers;
  for (const auto& [frame_idx, pose] : graph_from_frame) {
    const auto i = static_cast<std::size_t>(frame_idx);
    const FrameRecord& frame = input.frames[i];
    observers.push_back({&frame,
                         &input.cameras.at(static_cast<std::size_t>(frame.camera_idx)),
                         &all.frames[i],
                         pose});
  }
  LandmarkTracker tracker(options, all.kind, &observers);
  for (std::size_t i = 0; i < observers.size(); ++i) {
    if (observers[i].features->IsDescribed()) tracker.Add(static_cast<int>(i));
  }
  std::vector<Track> tracks;
  for (const LandmarkTrack& found : tracker.TakeTracks()) {
    if (found.sightings.size() < 2) continue;
    Track& track = tracks.emplace_back();
    for (const Sighting& s : found.sightings) {
      track.push_back(
          {observers[static_cast<std::size_t>(s.frame_idx)].frame->frame_idx, s.feature_idx});
    }
  }
  return tracks;
}

}  // namespace nightmap
