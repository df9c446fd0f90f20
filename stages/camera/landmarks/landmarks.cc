// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/landmarks.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/trajectory_io.h"
#include "stages/camera/landmarks/keep_landmarks.h"
#include "stages/camera/landmarks/region_landmarks.h"

namespace nightmap {
namespace {

constexpr std::size_t kRegionsAtOnce = 3;  // in memory, each with its features and tracks

void CheckInput(const LandmarksInput& input) {
  CheckFeaturesOfFrames(input.frames, input.features.Heads());
  if (input.tree->Kind() != input.features.Heads().kind) {
    throw InputError({{"vocabulary"}}, "trained on another descriptor");
  }
}

LandmarkMap HeadOf(const LandmarksInput& input, const std::vector<PosedFrame>& observers) {
  LandmarkMap head;
  head.kind = input.features.Heads().kind;
  head.extraction = input.features.Heads().extraction;
  head.num_word_levels = input.tree->Depth();
  for (const PosedFrame& observer : observers) {
    head.keyframes.push_back(
        {observer.frame->frame_idx, observer.frame->time_ns, observer.map_from_camera});
  }
  return head;
}

void KeepSome(std::size_t num_observers, std::size_t count, std::vector<Landmark>* landmarks) {
  std::vector<Landmark> kept;
  for (const std::size_t i : ChooseLandmarks(*landmarks, num_observers, count)) {
    kept.push_back(std::move((*landmarks)[i]));
  }
  *landmarks = std::move(kept);
}

LandmarkMap Assemble(const LandmarksInput& input,
                     const RegionObservers& seen,
                     const std::vector<Landmark>& landmarks) {
  LandmarkMap map;
  map.kind = input.features.Heads().kind;
  map.num_word_levels = input.tree->Depth();
  const int size = DescriptorSize(map.kind);
  for (const Landmark& landmark : landmarks) {
    const int landmark_idx = map.NumLandmarks();
    map.positions_in_map.push_back(landmark.position_in_map);
    map.position_sigmas_m.push_back(static_cast<float>(landmark.sigma_m));
    auto& keyframes = map.landmark_keyframes.emplace_back();
    auto& features = map.landmark_features.emplace_back();
    for (const Sighting& sighting : landmark.sightings) {
      const auto observer = static_cast<std::size_t>(sighting.frame_idx);
      keyframes.push_back(seen.observer_idxs[observer]);
      features.push_back(
          seen.feature_idxs[observer][static_cast<std::size_t>(sighting.feature_idx)]);
    }
    for (const std::uint8_t* descriptor : landmark.descriptors) {
      map.descriptors.insert(map.descriptors.end(), descriptor, descriptor + size);
      map.descriptor_landmarks.push_back(landmark_idx);
    }
  }
  return map;
}

void AssignWords(const VocabularyTree& tree, int num_threads, LandmarkMap* map) {
  const auto depth = static_cast<std::size_t>(map->num_word_levels);
  map->words.resize(map->descriptor_landmarks.size() * depth);
  ParallelFor(map->descriptor_landmarks.size(), num_threads, [&](std::size_t i) {
    const std::vector<int> path = tree.Path(map->Descriptor(static_cast<int>(i)));
    for (std::size_t level = 0; level < depth && !path.empty(); ++level) {
      map->words[i * depth + level] = path[std::min(level, path.size() - 1)];
    }
  });
}

// How many of max_landmarks go to each region.
class Shares {
 public:
  Shares(int max_landmarks, std::size_t num_observers)
      : max_landmarks_(static_cast<std::size_t>(max_landmarks)), num_observers_(num_observers) {}

  std::size_t Next(const SiteRegion& region) {
    const std::size_t before = num_before_ * max_landmarks_ / num_observers_;
    num_before_ += region.num_observers;
    return num_before_ * max_landmarks_ / num_observers_ - before;
  }

 private:
  std::size_t max_landmarks_;
  std::size_t num_observers_;
  std::size_t num_before_ = 0;
};

void Count(const LandmarkMap& map, LandmarksFigures* figures) {
  figures->num_landmarks += map.positions_in_map.size();
  figures->num_descriptors += map.descriptor_landmarks.size();
  for (const auto& keyframes : map.landmark_keyframes) {
    figures->num_observations += keyframes.size();
  }
}

std::size_t NumSeeing(const std::vector<SiteRegion>& regions) {
  std::size_t num_seeing = 0;
  for (const SiteRegion& region : regions) num_seeing += region.seen_by.size();
  return num_seeing;
}

// The observers of the site, in order of time.
std::vector<PosedFrame> FindObservers(const LandmarksOptions& options,
                                      const LandmarksInput& input) {
  const bool are_all = options.observers == "all";
  const auto& poses = are_all ? input.trajectory : input.keyframes;
  std::vector<PosedFrame> observers;
  std::size_t num_found = 0;
  for (std::size_t i = 0; i < input.frames.size(); ++i) {
    const FrameRecord& frame = input.frames[i];
    const int pose = FindPose(poses, frame.time_ns);
    num_found += pose >= 0;
    if (pose < 0 || !input.features.Heads().frames[i].IsDescribed()) continue;
    observers.push_back({&frame,
                         &input.cameras.at(static_cast<std::size_t>(frame.camera_idx)),
                         poses[static_cast<std::size_t>(pose)].pose});
  }
  if (num_found != poses.size()) {
    throw InputError(
        {{are_all ? "trajectory" : "keyframes"}, {"frames"}},
        "{} of {} poses have the time of no frame; a file is damaged or another site's",
        poses.size() - num_found,
        poses.size());
  }
  std::ranges::stable_sort(observers, {}, [](const PosedFrame& o) { return o.frame->time_ns; });
  return observers;
}

RegionOptions RegionsOf(const LandmarksOptions& options, const LandmarksInput& input) {
  return {.max_observers = input.max_region_observers,
          .margin_m = 3 * options.tracker.voxel_size_m};
}

}  // namespace

LandmarkMap HeadOfMap(const LandmarksOptions& options, const LandmarksInput& input) {
  CheckInput(input);
  return HeadOf(input, FindObservers(options, input));
}

LandmarksFigures RunLandmarks(const LandmarksOptions& options,
                              const LandmarksInput& input,
                              const TakeRegion& take_region,
                              Progress& progress,
                              int num_threads) {
  CheckInput(input);
  const DescriptorKind kind = input.features.Heads().kind;
  const std::vector<PosedFrame> observers = FindObservers(options, input);
  LandmarksFigures figures;
  figures.num_observers = observers.size();
  if (observers.empty()) return figures;
  const RegionOptions of_regions = RegionsOf(options, input);
  const std::vector<SiteRegion> regions =
      CutSite(of_regions, input.features, observers, num_threads);
  figures.num_regions = regions.size();
  progress.Start(NumSeeing(regions));
  TakenFeatures taken(observers.size());
  Shares shares(options.max_landmarks, observers.size());
  const std::size_t num_at_once =
      std::min(kRegionsAtOnce, static_cast<std::size_t>(std::max(num_threads, 1)));
  for (std::size_t begin = 0; begin < regions.size(); begin += num_at_once) {
    std::vector<RegionTracks> tracks(std::min(num_at_once, regions.size() - begin));
    ParallelFor(tracks.size(), num_threads, [&](std::size_t i) {
      tracks[i] =
          TrackRegion(of_regions, options.tracker, input.features, observers, regions[begin + i]);
      progress.Advance(regions[begin + i].seen_by.size());
    });
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const RegionTracks of_region = std::move(tracks[i]);
      const SiteRegion& region = regions[begin + i];
      auto landmarks = FinishRegion(options, kind, region.box, of_region, num_threads, &taken);
      figures.num_found += landmarks.size();
      KeepSome(of_region.seen.observers.size(), shares.Next(region), &landmarks);
      LandmarkMap map = Assemble(input, of_region.seen, landmarks);
      AssignWords(*input.tree, num_threads, &map);
      Count(map, &figures);
      take_region(region.box, map);
    }
  }
  progress.Finish();
  return figures;
}

}  // namespace nightmap
