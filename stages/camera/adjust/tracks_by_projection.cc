// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/tracks_by_projection.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/camera/region_tracks.h"

namespace nightmap {
namespace {

constexpr std::size_t kRegionsAtOnce = 3;  // in memory, each with its features and tracks

// The graph's frame is about that of a camera that is carried upright: y points down.
RegionOptions RegionsOf(const LandmarkTrackerOptions& options, std::size_t max_observers) {
  RegionOptions regions{.max_observers = max_observers, .margin_m = 3 * options.voxel_size_m};
  regions.plane_from_map << 1, 0, 0, 0, 0, 1;
  return regions;
}

std::vector<PosedFrame> DescribedFrames(const AdjustInput& input,
                                        const std::map<int, Rigid3>& graph_from_frame) {
  std::vector<PosedFrame> observers;
  for (const auto& [frame_idx, pose] : graph_from_frame) {
    const auto i = static_cast<std::size_t>(frame_idx);
    if (!input.features.Heads().frames[i].IsDescribed()) continue;
    const FrameRecord& frame = input.frames[i];
    observers.push_back(
        {&frame, &input.cameras.at(static_cast<std::size_t>(frame.camera_idx)), pose});
  }
  return observers;
}

// Tracks that lie in a region, without features of earlier ones.
class TrackCollector {
 public:
  explicit TrackCollector(const std::vector<PosedFrame>& observers)
      : observers_(observers), taken_(observers.size()) {}

  void Add(const RegionOptions& options, const Rectangle& box, const RegionTracks& region) {
    for (const LandmarkTrack& found : region.tracks) {
      if (found.sightings.size() < 2) continue;
      if (!box.Contains(options.plane_from_map * found.position_in_map)) continue;
      Track track;
      for (const Sighting& s : found.sightings) {
        const Sighting in_site = region.InSite(s);
        if (taken_.IsTaken(in_site)) continue;
        taken_.Take(in_site);
        const auto observer = static_cast<std::size_t>(in_site.frame_idx);
        track.push_back({observers_[observer].frame->frame_idx, in_site.feature_idx});
      }
      if (track.size() >= 2) tracks_.Add(track);
    }
  }

  TrackList Tracks() && { return std::move(tracks_); }

 private:
  const std::vector<PosedFrame>& observers_;
  TakenFeatures taken_;
  TrackList tracks_;
};

}  // namespace

TrackList TracksByProjection(const AdjustInput& input,
                             const std::map<int, Rigid3>& graph_from_frame,
                             const LandmarkTrackerOptions& options,
                             int num_threads) {
  const std::vector<PosedFrame> observers = DescribedFrames(input, graph_from_frame);
  if (observers.empty()) return {};
  const RegionOptions of_regions = RegionsOf(options, input.max_region_observers);
  const auto regions = CutSite(of_regions, input.features, observers, num_threads);
  const std::size_t num_at_once =
      std::min(kRegionsAtOnce, static_cast<std::size_t>(std::max(num_threads, 1)));
  TrackCollector collector(observers);
  for (std::size_t begin = 0; begin < regions.size(); begin += num_at_once) {
    std::vector<RegionTracks> tracks(std::min(num_at_once, regions.size() - begin));
    ParallelFor(tracks.size(), num_threads, [&](std::size_t i) {
      tracks[i] = TrackRegion(of_regions, options, input.features, observers, regions[begin + i]);
    });
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      collector.Add(of_regions, regions[begin + i].box, tracks[i]);
    }
  }
  return std::move(collector).Tracks();
}

}  // namespace nightmap
