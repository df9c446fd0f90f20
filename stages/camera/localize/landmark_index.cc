// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/landmark_index.h"

#include <algorithm>
#include <limits>
#include <nanoflann.hpp>
#include <set>
#include <tuple>

#include "pipeline/camera/descriptor_distance.h"

namespace nightmap {
namespace {

constexpr int kFar = std::numeric_limits<int>::max();

// Adapter of a list of points for nanoflann.
struct PointCloud {
  const std::vector<Eigen::Vector3d>& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

}  // namespace

std::vector<LandmarkMatch> KeepOneToOne(std::vector<LandmarkMatch> matches) {
  std::ranges::sort(matches, [](const LandmarkMatch& a, const LandmarkMatch& b) {
    return std::tie(a.distance, a.feature, a.landmark) <
           std::tie(b.distance, b.feature, b.landmark);
  });
  std::set<int> features;
  std::set<int> landmarks;
  std::erase_if(matches, [&](const LandmarkMatch& match) {
    if (features.contains(match.feature) || landmarks.contains(match.landmark)) return true;
    features.insert(match.feature);
    landmarks.insert(match.landmark);
    return false;
  });
  return matches;
}

struct LandmarkIndex::SpatialTree {
  explicit SpatialTree(const std::vector<Eigen::Vector3d>& points)
      : cloud{points}, tree(3, cloud) {}
  PointCloud cloud;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointCloud>,
                                      PointCloud,
                                      3,
                                      std::size_t>
      tree;
};

LandmarkIndex::LandmarkIndex(const LocalizeOptions& options,
                             const LandmarkMap& map,
                             const VocabularyIndex& vocabulary)
    : options_(options),
      map_(map),
      vocabulary_(vocabulary),
      max_distance_(DistanceFromRelative(map.kind, options.max_descriptor_distance)),
      words_(map, vocabulary.tree),
      keyframe_landmarks_(map.KeyframeLandmarks()),
      descriptor_offsets_(map.DescriptorOffsets()),
      frame_keyframes_(vocabulary.frames.NumFrames(), -1),
      spatial_tree_(std::make_unique<SpatialTree>(map.positions_in_map)) {
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const auto frame = static_cast<std::size_t>(map.keyframes[i].frame_idx);
    if (frame < frame_keyframes_.size()) frame_keyframes_[frame] = static_cast<int>(i);
  }
}

LandmarkIndex::~LandmarkIndex() = default;

const std::uint8_t* LandmarkIndex::Descriptor(const FrameFeatures& features, int feature) const {
  return features.Feature(feature).Descriptor(map_.kind);
}

std::pair<int, int> LandmarkIndex::DescriptorsOf(int landmark) const {
  const auto i = static_cast<std::size_t>(landmark);
  return {descriptor_offsets_[i], descriptor_offsets_[i + 1]};
}

std::vector<int> LandmarkIndex::DescriptorsOf(const std::vector<int>& landmarks) const {
  std::vector<int> descriptors;
  for (const int landmark : landmarks) {
    const auto [begin, end] = DescriptorsOf(landmark);
    for (int i = begin; i < end; ++i) descriptors.push_back(i);
  }
  return descriptors;
}

std::vector<int> LandmarkIndex::LandmarksOf(const std::vector<int>& keyframes) const {
  std::vector<int> landmarks;
  for (const int keyframe : keyframes) {
    const auto& seen = keyframe_landmarks_[static_cast<std::size_t>(keyframe)];
    landmarks.insert(landmarks.end(), seen.begin(), seen.end());
  }
  std::ranges::sort(landmarks);
  landmarks.erase(std::unique(landmarks.begin(), landmarks.end()), landmarks.end());
  return landmarks;
}

int LandmarkIndex::KeyframeOf(int frame_idx) const {
  return frame_keyframes_[static_cast<std::size_t>(frame_idx)];
}

std::vector<int> LandmarkIndex::Nearest(int landmark, int count) const {
  const std::size_t num_asked =
      std::min(static_cast<std::size_t>(count) + 1, map_.positions_in_map.size());
  std::vector<std::size_t> found(num_asked);
  std::vector<double> squared_m(num_asked);
  spatial_tree_->tree.knnSearch(
      Position(landmark).data(), num_asked, found.data(), squared_m.data());
  std::vector<int> nearest;
  for (const std::size_t i : found) {
    if (static_cast<int>(i) != landmark) nearest.push_back(static_cast<int>(i));
  }
  nearest.resize(std::min(nearest.size(), num_asked - 1));
  return nearest;
}

int LandmarkIndex::Distance(const std::uint8_t* descriptor, int landmark) const {
  const auto [begin, end] = DescriptorsOf(landmark);
  int best = kFar;
  for (int i = begin; i < end; ++i) {
    best = std::min(best, DescriptorDistance(map_.kind, descriptor, map_.Descriptor(i)));
  }
  return best;
}

int LandmarkIndex::SearchWord(const std::uint8_t* descriptor) const {
  const VocabularyTree& tree = vocabulary_.tree;
  int word = tree.Word(descriptor, options_.search_level);
  if (OfWord(word).Size() <= options_.max_word_descriptors) return word;
  const std::vector<int> path = tree.Path(descriptor);
  for (auto level = static_cast<std::size_t>(options_.search_level); level < path.size(); ++level) {
    const int size = OfWord(path[level]).Size();
    if (size == 0) break;
    word = path[level];
    if (size <= options_.max_word_descriptors) break;
  }
  return word;
}

std::vector<int> LandmarkIndex::Distances(const std::uint8_t* descriptor,
                                          const WordIndex::Block& word) const {
  const auto size = static_cast<std::size_t>(DescriptorSize(map_.kind));
  std::vector<int> distances(word.rows.size());
  for (std::size_t i = 0; i < distances.size(); ++i) {
    distances[i] = DescriptorDistance(map_.kind, descriptor, word.values + i * size);
  }
  return distances;
}

std::optional<LandmarkMatch> LandmarkIndex::Match(const FrameFeatures& features,
                                                  int feature,
                                                  std::span<const int> candidates) const {
  const std::uint8_t* descriptor = Descriptor(features, feature);
  std::vector<int> distances;
  for (const int candidate : candidates) {
    distances.push_back(DescriptorDistance(map_.kind, descriptor, map_.Descriptor(candidate)));
  }
  return Best(feature, candidates, distances);
}

std::optional<LandmarkMatch> LandmarkIndex::MatchInWord(const FrameFeatures& features,
                                                        int feature,
                                                        int word) const {
  const WordIndex::Block block = OfWord(word);
  return Best(feature, block.rows, Distances(Descriptor(features, feature), block));
}

std::optional<LandmarkMatch> LandmarkIndex::Best(int feature,
                                                 std::span<const int> candidates,
                                                 const std::vector<int>& distances) const {
  LandmarkMatch best{feature, -1, kFar};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (distances[i] < best.distance) best = {feature, LandmarkOf(candidates[i]), distances[i]};
  }
  if (best.distance > max_distance_) return {};
  int second = kFar;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (distances[i] >= second) continue;
    const double apart_m = (Position(LandmarkOf(candidates[i])) - Position(best.landmark)).norm();
    if (apart_m > options_.same_point_radius_m) second = distances[i];
  }
  if (second == kFar) second = max_distance_;
  if (!PassesRatioTest(map_.kind, best.distance, second, options_.max_ratio)) return {};
  return best;
}

}  // namespace nightmap
