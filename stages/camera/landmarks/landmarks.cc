// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/landmarks.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/trajectory_io.h"
#include "stages/camera/landmarks/keep_landmarks.h"
#include "stages/camera/landmarks/landmark_of_track.h"

namespace nightmap {
namespace {

void CheckInput(const LandmarksInput& input) {
  CheckFeaturesOfFrames(input.frames, input.features);
  if (input.tree->Kind() != input.features.kind) {
    throw InputError({{"vocabulary"}}, "trained on another descriptor");
  }
}

std::vector<Observer> MakeObservers(const LandmarksOptions& options, const LandmarksInput& input) {
  const bool are_all = options.observers == "all";
  const auto& poses = are_all ? input.trajectory : input.keyframes;
  std::vector<Observer> observers;
  std::size_t num_found = 0;
  for (std::size_t i = 0; i < input.frames.size(); ++i) {
    const FrameRecord& frame = input.frames[i];
    const int pose = FindPose(poses, frame.time_ns);
    num_found += pose >= 0;
    if (pose < 0 || !input.features.frames[i].IsDescribed()) continue;
    observers.push_back({&frame,
                         &input.cameras.at(static_cast<std::size_t>(frame.camera_idx)),
                         &input.features.frames[i],
                         poses[static_cast<std::size_t>(pose)].pose});
  }
  if (num_found != poses.size()) {
    throw InputError(
        {{are_all ? "trajectory" : "keyframes"}, {"frames"}},
        "{} of {} poses have the time of no frame; a file is damaged or another site's",
        poses.size() - num_found,
        poses.size());
  }
  std::stable_sort(observers.begin(), observers.end(), [](const Observer& a, const Observer& b) {
    return a.frame->time_ns < b.frame->time_ns;
  });
  return observers;
}

void KeepSome(std::size_t num_observers, std::size_t count, std::vector<Landmark>* landmarks) {
  std::vector<Landmark> kept;
  for (const std::size_t i : ChooseLandmarks(*landmarks, num_observers, count)) {
    kept.push_back(std::move((*landmarks)[i]));
  }
  *landmarks = std::move(kept);
}

LandmarkMap Assemble(const LandmarksInput& input,
                     const std::vector<Observer>& observers,
                     const std::vector<Landmark>& landmarks) {
  LandmarkMap map;
  map.kind = input.features.kind;
  map.extraction = input.features.extraction;
  map.num_word_levels = input.tree->Depth();
  for (const Observer& observer : observers) {
    map.keyframes.push_back(
        {observer.frame->frame_idx, observer.frame->time_ns, observer.map_from_camera});
  }
  const int size = DescriptorSize(map.kind);
  for (const Landmark& landmark : landmarks) {
    const int landmark_idx = map.NumLandmarks();
    map.positions_in_map.push_back(landmark.position_in_map);
    map.position_sigmas_m.push_back(static_cast<float>(landmark.sigma_m));
    auto& keyframes = map.landmark_keyframes.emplace_back();
    auto& features = map.landmark_features.emplace_back();
    for (const Sighting& sighting : landmark.sightings) {
      keyframes.push_back(sighting.frame_idx);
      features.push_back(sighting.feature_idx);
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

}  // namespace

LandmarksResult RunLandmarks(const LandmarksOptions& options,
                             const LandmarksInput& input,
                             Progress& progress,
                             int num_threads) {
  CheckInput(input);
  const std::vector<Observer> observers = MakeObservers(options, input);
  LandmarkTracker tracker(options.tracker, input.features.kind, &observers);
  progress.Start(observers.size());
  for (std::size_t i = 0; i < observers.size(); ++i) {
    tracker.Add(static_cast<int>(i));
    progress.Advance();
  }
  progress.Finish();
  const std::vector<LandmarkTrack> tracks = tracker.TakeTracks();
  std::vector<std::optional<Landmark>> finished(tracks.size());
  ParallelFor(tracks.size(), num_threads, [&](std::size_t i) {
    finished[i] = LandmarkOfTrack(options, input.features.kind, observers, tracks[i]);
  });
  std::vector<Landmark> landmarks;
  for (auto& landmark : finished) {
    if (landmark) landmarks.push_back(std::move(*landmark));
  }
  LandmarksResult result;
  result.num_found = landmarks.size();
  KeepSome(observers.size(), static_cast<std::size_t>(options.max_landmarks), &landmarks);
  result.map = Assemble(input, observers, landmarks);
  AssignWords(*input.tree, num_threads, &result.map);
  return result;
}

}  // namespace nightmap
