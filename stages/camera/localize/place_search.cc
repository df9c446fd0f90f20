// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/place_search.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "pipeline/base/union_find.h"
#include "pipeline/camera/pixel_grid.h"

namespace nightmap {
namespace {

void JoinAll(const std::vector<int>& keyframes, UnionFind* places) {
  for (const int keyframe : keyframes) {
    places->Join(static_cast<std::size_t>(keyframes[0]), static_cast<std::size_t>(keyframe));
  }
}

// Retrieves keyframes, best first. Asks for more frames than keyframes, because not every mapping
// frame is a keyframe.
std::vector<int> Retrieve(const LocalizeOptions& options,
                          const LandmarkIndex& index,
                          const FrameFeatures& features) {
  const auto words = index.Tree().LeafWords(features.descriptors, 1);
  std::vector<int> keyframes;
  for (const auto& result : index.Frames().Query(words, 8 * options.num_retrieved_keyframes)) {
    const int keyframe = index.KeyframeOf(result.frame_idx);
    if (keyframe >= 0) keyframes.push_back(keyframe);
    if (static_cast<int>(keyframes.size()) >= options.num_retrieved_keyframes) break;
  }
  return keyframes;
}

// Splits keyframes by covisibility; parts are in the order of their first keyframe.
std::vector<std::vector<int>> PartByCovisibility(const LandmarkIndex& index,
                                                 const std::vector<int>& keyframes) {
  UnionFind places(index.Map().keyframes.size());
  for (const int landmark : index.LandmarksOf(keyframes)) {
    std::vector<int> seen_by;
    for (const int keyframe : index.KeyframesOf(landmark)) {
      if (std::ranges::find(keyframes, keyframe) != keyframes.end()) seen_by.push_back(keyframe);
    }
    JoinAll(seen_by, &places);
  }
  std::vector<std::vector<int>> parts;
  std::map<std::size_t, std::size_t> part_of;
  for (const int keyframe : keyframes) {
    const auto [found, is_new] =
        part_of.try_emplace(places.Find(static_cast<std::size_t>(keyframe)), parts.size());
    if (is_new) parts.emplace_back();
    parts[found->second].push_back(keyframe);
  }
  return parts;
}

// The keyframes that see the most landmarks of `seen`.
std::vector<int> MostCovisible(const LandmarkIndex& index,
                               const std::vector<int>& seen,
                               int num_keyframes) {
  std::vector<int> votes(index.Map().keyframes.size(), 0);
  for (const int landmark : seen) {
    for (const int keyframe : index.KeyframesOf(landmark)) {
      ++votes[static_cast<std::size_t>(keyframe)];
    }
  }
  std::vector<int> keyframes(votes.size());
  std::iota(keyframes.begin(), keyframes.end(), 0);
  const auto count = std::min(keyframes.size(), static_cast<std::size_t>(num_keyframes));
  std::ranges::partial_sort(
      keyframes, keyframes.begin() + static_cast<std::ptrdiff_t>(count), [&](int a, int b) {
        const int votes_a = votes[static_cast<std::size_t>(a)];
        const int votes_b = votes[static_cast<std::size_t>(b)];
        return votes_a != votes_b ? votes_a > votes_b : a < b;
      });
  keyframes.resize(count);
  return keyframes;
}

}  // namespace

std::vector<LandmarkMatch> LargestPlace(const LandmarkIndex& index,
                                        const std::vector<LandmarkMatch>& matches) {
  UnionFind places(index.Map().keyframes.size());
  for (const LandmarkMatch& match : matches) JoinAll(index.KeyframesOf(match.landmark), &places);
  const auto place = [&](const LandmarkMatch& match) {
    const std::vector<int>& seen_by = index.KeyframesOf(match.landmark);
    return seen_by.empty() ? -1
                           : static_cast<int>(places.Find(static_cast<std::size_t>(seen_by[0])));
  };
  std::map<int, int> sizes;
  for (const LandmarkMatch& match : matches) ++sizes[place(match)];
  const auto largest = std::ranges::max_element(sizes, {}, [](const auto& s) { return s.second; });
  std::vector<LandmarkMatch> kept;
  std::ranges::copy_if(matches, std::back_inserter(kept), [&](const LandmarkMatch& match) {
    return place(match) == largest->first;
  });
  return kept;
}

std::vector<std::vector<LandmarkMatch>> SearchByRetrieval(const LocalizeOptions& options,
                                                          const LandmarkIndex& index,
                                                          const FrameFeatures& features) {
  std::vector<std::vector<LandmarkMatch>> result;
  for (const auto& part : PartByCovisibility(index, Retrieve(options, index, features))) {
    const std::vector<int> candidates = index.DescriptorsOf(index.LandmarksOf(part));
    std::vector<LandmarkMatch> matches;
    for (int feature = 0; feature < features.NumFeatures(); ++feature) {
      const auto match = index.Match(features, feature, candidates);
      if (match) matches.push_back(*match);
    }
    result.push_back(KeepOneToOne(std::move(matches)));
  }
  return result;
}

std::vector<LandmarkMatch> SearchRivals(const LocalizeOptions& options,
                                        const LandmarkIndex& index,
                                        const FrameFeatures& features,
                                        const std::vector<LandmarkMatch>& matches) {
  std::vector<LandmarkMatch> rivals;
  for (const LandmarkMatch& match : matches) {
    const std::uint8_t* descriptor = index.Descriptor(features, match.feature);
    const WordIndex::Block word = index.OfWord(index.SearchWord(descriptor));
    const std::vector<int> distances = index.Distances(descriptor, word);
    LandmarkMatch best{match.feature, -1, index.MaxDistance()};
    for (std::size_t i = 0; i < distances.size(); ++i) {
      if (distances[i] >= best.distance) continue;
      const int landmark = index.LandmarkOf(word.rows[i]);
      const double apart_m = (index.Position(landmark) - index.Position(match.landmark)).norm();
      if (apart_m >= options.rival_distance_m) best = {match.feature, landmark, distances[i]};
    }
    if (best.landmark >= 0) rivals.push_back(best);
  }
  if (rivals.empty()) return {};
  std::vector<int> landmarks;
  for (const LandmarkMatch& rival : rivals) landmarks.push_back(rival.landmark);
  const int keyframe = MostCovisible(index, landmarks, 1)[0];
  std::erase_if(rivals, [&](const LandmarkMatch& rival) {
    return !std::ranges::binary_search(index.KeyframesOf(rival.landmark), keyframe);
  });
  return KeepOneToOne(std::move(rivals));
}

std::vector<LandmarkMatch> SearchByPose(const LocalizeOptions& options,
                                        const LandmarkIndex& index,
                                        const FrameFeatures& features,
                                        const Camera& camera,
                                        const Rigid3& camera_from_map,
                                        const std::vector<int>& seen) {
  PixelGrid grid(camera, options.guided_radius_px);
  for (int i = 0; i < features.NumFeatures(); ++i) {
    grid.Add(features.Feature(i).Pixel(), i);
  }
  std::vector<LandmarkMatch> matches;
  for (const int landmark :
       index.LandmarksOf(MostCovisible(index, seen, options.num_guided_keyframes))) {
    const Eigen::Vector3d point = camera_from_map * index.Position(landmark);
    if (point.z() <= 0.01) continue;
    const auto pixel = camera.ProjectUndistorted(point);
    const auto raw_pixel = camera.Project(point);
    if (!pixel || !raw_pixel || !camera.Contains(*raw_pixel)) continue;
    grid.ForNear(*pixel, [&](int feature) {
      if ((features.Feature(feature).Pixel() - *pixel).norm() > options.guided_radius_px) return;
      const int distance = index.Distance(index.Descriptor(features, feature), landmark);
      if (distance <= index.MaxDistance()) matches.push_back({feature, landmark, distance});
    });
  }
  return KeepOneToOne(std::move(matches));
}

}  // namespace nightmap
