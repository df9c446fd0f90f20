// SPDX-License-Identifier: Apache-2.0
#include "stages/localize/landmark_matcher.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "pipeline/vision/descriptor_distance.h"
#include "pipeline/vision/pixel_grid.h"

namespace nightmap {
namespace {

constexpr int kFar = std::numeric_limits<int>::max();

bool IsCloser(const LandmarkMatch& a, const LandmarkMatch& b) {
  return std::tie(a.distance, a.feature, a.landmark) < std::tie(b.distance, b.feature, b.landmark);
}

// Most similar first; each feature and each landmark is used once.
std::vector<LandmarkMatch> KeepOneToOne(std::vector<LandmarkMatch> matches,
                                        int num_features,
                                        int num_landmarks) {
  std::sort(matches.begin(), matches.end(), IsCloser);
  std::vector<bool> feature_used(static_cast<std::size_t>(num_features), false);
  std::vector<bool> landmark_used(static_cast<std::size_t>(num_landmarks), false);
  std::vector<LandmarkMatch> kept;
  for (const LandmarkMatch& match : matches) {
    const auto feature = static_cast<std::size_t>(match.feature);
    const auto landmark = static_cast<std::size_t>(match.landmark);
    if (feature_used[feature] || landmark_used[landmark]) continue;
    feature_used[feature] = true;
    landmark_used[landmark] = true;
    kept.push_back(match);
  }
  return kept;
}

void SortUnique(std::vector<int>* values) {
  std::sort(values->begin(), values->end());
  values->erase(std::unique(values->begin(), values->end()), values->end());
}

}  // namespace

LandmarkMatcher::LandmarkMatcher(const LocalizeOptions& options,
                                 const LandmarkMap& map,
                                 const Vocabulary& vocabulary)
    : options_(options),
      map_(map),
      vocabulary_(vocabulary),
      keyframe_landmarks_(map.KeyframeLandmarks()),
      descriptor_offsets_(map.DescriptorOffsets()),
      word_descriptors_(static_cast<std::size_t>(vocabulary.tree.NumNodes())),
      frame_keyframes_(vocabulary.inverted_file.Words().size(), -1),
      max_distance_(DistanceFromRelative(map.kind, options.max_descriptor_distance)) {
  const int level = std::min(options.search_level, map.num_word_levels);
  for (int i = 0; i < map.NumDescriptors(); ++i) {
    word_descriptors_[static_cast<std::size_t>(map.Word(i, level))].push_back(i);
  }
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const auto frame = static_cast<std::size_t>(map.keyframes[i].frame_idx);
    if (frame < frame_keyframes_.size()) frame_keyframes_[frame] = static_cast<int>(i);
  }
}

const std::uint8_t* LandmarkMatcher::Descriptor(const FrameFeatures& features, int feature) const {
  return &features.descriptors[static_cast<std::size_t>(feature) *
                               static_cast<std::size_t>(DescriptorSize(map_.kind))];
}

std::optional<LandmarkMatch> LandmarkMatcher::MatchFeature(
    const std::uint8_t* descriptor, int feature, const std::vector<int>& candidates) const {
  std::vector<int> distances(candidates.size());
  LandmarkMatch best{feature, -1, kFar};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    distances[i] = DescriptorDistance(map_.kind, descriptor, map_.Descriptor(candidates[i]));
    if (distances[i] >= best.distance) continue;
    best.distance = distances[i];
    best.landmark = map_.descriptor_landmarks[static_cast<std::size_t>(candidates[i])];
  }
  if (best.distance > max_distance_) return {};
  const Eigen::Vector3d& point = map_.positions_in_map[static_cast<std::size_t>(best.landmark)];
  int second = kFar;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (distances[i] >= second) continue;
    const int landmark = map_.descriptor_landmarks[static_cast<std::size_t>(candidates[i])];
    const Eigen::Vector3d& other = map_.positions_in_map[static_cast<std::size_t>(landmark)];
    if ((other - point).norm() > options_.same_point_radius_m) second = distances[i];
  }
  // A word with a single point leaves nothing to compare with: its distance must do.
  if (second == kFar) second = max_distance_;
  if (!PassesRatioTest(map_.kind, best.distance, second, options_.max_ratio)) return {};
  return best;
}

std::vector<LandmarkMatch> LandmarkMatcher::SearchByWords(const FrameFeatures& features) const {
  const auto num_features = static_cast<std::size_t>(features.NumFeatures());
  std::vector<const std::vector<int>*> candidates(num_features);
  for (std::size_t i = 0; i < num_features; ++i) {
    const int word =
        vocabulary_.tree.Word(Descriptor(features, static_cast<int>(i)), options_.search_level);
    candidates[i] = &word_descriptors_[static_cast<std::size_t>(word)];
  }
  std::vector<int> order(num_features);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return candidates[static_cast<std::size_t>(a)]->size() <
           candidates[static_cast<std::size_t>(b)]->size();
  });
  std::vector<LandmarkMatch> matches;
  for (const int feature : order) {
    if (static_cast<int>(matches.size()) >= options_.max_matches) break;
    const auto match = MatchFeature(
        Descriptor(features, feature), feature, *candidates[static_cast<std::size_t>(feature)]);
    if (match) matches.push_back(*match);
  }
  return KeepOneToOne(std::move(matches), features.NumFeatures(), map_.NumLandmarks());
}

std::vector<int> LandmarkMatcher::LandmarksOf(const std::vector<int>& keyframes) const {
  std::vector<int> landmarks;
  for (const int keyframe : keyframes) {
    const auto& seen = keyframe_landmarks_[static_cast<std::size_t>(keyframe)];
    landmarks.insert(landmarks.end(), seen.begin(), seen.end());
  }
  SortUnique(&landmarks);
  return landmarks;
}

std::vector<int> LandmarkMatcher::DescriptorsOf(const std::vector<int>& landmarks) const {
  std::vector<int> descriptors;
  for (const int landmark : landmarks) {
    const auto i = static_cast<std::size_t>(landmark);
    for (int k = descriptor_offsets_[i]; k < descriptor_offsets_[i + 1]; ++k) {
      descriptors.push_back(k);
    }
  }
  return descriptors;
}

std::vector<LandmarkMatch> LandmarkMatcher::SearchByRetrieval(const FrameFeatures& features) const {
  // More frames than keyframes are asked for: not every mapping frame is a keyframe.
  const auto words = vocabulary_.tree.LeafWords(features.descriptors, 1);
  const auto results = vocabulary_.inverted_file.Query(words, 8 * options_.num_retrieved_keyframes);
  std::vector<int> keyframes;
  for (const auto& result : results) {
    const int keyframe = frame_keyframes_[static_cast<std::size_t>(result.frame_idx)];
    if (keyframe >= 0) keyframes.push_back(keyframe);
    if (static_cast<int>(keyframes.size()) >= options_.num_retrieved_keyframes) break;
  }
  const std::vector<int> candidates = DescriptorsOf(LandmarksOf(keyframes));
  std::vector<LandmarkMatch> matches;
  for (int feature = 0; feature < features.NumFeatures(); ++feature) {
    const auto match = MatchFeature(Descriptor(features, feature), feature, candidates);
    if (match) matches.push_back(*match);
  }
  return KeepOneToOne(std::move(matches), features.NumFeatures(), map_.NumLandmarks());
}

// The landmarks of the keyframes that see most of `seen`.
std::vector<int> LandmarkMatcher::CovisibleLandmarks(const std::vector<int>& seen) const {
  std::vector<int> votes(map_.keyframes.size(), 0);
  for (const int landmark : seen) {
    for (const int keyframe : map_.landmark_keyframes[static_cast<std::size_t>(landmark)]) {
      ++votes[static_cast<std::size_t>(keyframe)];
    }
  }
  std::vector<int> keyframes(votes.size());
  std::iota(keyframes.begin(), keyframes.end(), 0);
  std::stable_sort(keyframes.begin(), keyframes.end(), [&](int a, int b) {
    return votes[static_cast<std::size_t>(a)] > votes[static_cast<std::size_t>(b)];
  });
  const auto count = static_cast<std::size_t>(options_.num_guided_keyframes);
  keyframes.resize(std::min(keyframes.size(), count));
  return LandmarksOf(keyframes);
}

int LandmarkMatcher::DistanceToLandmark(const std::uint8_t* descriptor, int landmark) const {
  const auto i = static_cast<std::size_t>(landmark);
  int best = kFar;
  for (int k = descriptor_offsets_[i]; k < descriptor_offsets_[i + 1]; ++k) {
    best = std::min(best, DescriptorDistance(map_.kind, descriptor, map_.Descriptor(k)));
  }
  return best;
}

std::vector<LandmarkMatch> LandmarkMatcher::SearchByPose(const FrameFeatures& features,
                                                         const Camera& camera,
                                                         const Rigid3& camera_from_map,
                                                         const std::vector<int>& seen) const {
  PixelGrid grid(camera, options_.guided_radius_px);
  for (int i = 0; i < features.NumFeatures(); ++i) {
    grid.Add(features.keypoints_px[static_cast<std::size_t>(i)].cast<double>(), i);
  }
  std::vector<LandmarkMatch> matches;
  for (const int landmark : CovisibleLandmarks(seen)) {
    const Eigen::Vector3d point =
        camera_from_map * map_.positions_in_map[static_cast<std::size_t>(landmark)];
    if (point.z() <= 0.01) continue;
    const auto pixel = camera.ProjectUndistorted(point);
    if (!pixel || !camera.Contains(*pixel)) continue;
    grid.ForNear(*pixel, [&](int feature) {
      const auto& keypoint = features.keypoints_px[static_cast<std::size_t>(feature)];
      if ((keypoint.cast<double>() - *pixel).norm() > options_.guided_radius_px) return;
      const int distance = DistanceToLandmark(Descriptor(features, feature), landmark);
      if (distance <= max_distance_) matches.push_back({feature, landmark, distance});
    });
  }
  return KeepOneToOne(std::move(matches), features.NumFeatures(), map_.NumLandmarks());
}

}  // namespace nightmap
