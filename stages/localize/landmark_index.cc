// SPDX-License-Identifier: Apache-2.0
#include "stages/localize/landmark_index.h"

#include <algorithm>
#include <limits>
#include <nanoflann.hpp>
#include <set>
#include <tuple>

#include "pipeline/vision/descriptor_distance.h"

namespace nightmap {
namespace {

constexpr int kFar = std::numeric_limits<int>::max();

std::vector<int> WordsAtLevel(const LandmarkMap& map, int level) {
  std::vector<int> words;
  for (int i = 0; i < map.NumDescriptors(); ++i) words.push_back(map.Word(i, level));
  return words;
}

// What nanoflann wants to know of a list of points.
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

LandmarkIndex::Lists::Lists(int num_lists, const std::vector<int>& list_of_item)
    : begins_(static_cast<std::size_t>(num_lists) + 1, 0), items_(list_of_item.size()) {
  for (const int list : list_of_item) ++begins_[static_cast<std::size_t>(list) + 1];
  for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
  std::vector<int> next = begins_;
  for (std::size_t i = 0; i < list_of_item.size(); ++i) {
    items_[static_cast<std::size_t>(next[static_cast<std::size_t>(list_of_item[i])]++)] =
        static_cast<int>(i);
  }
}

std::span<const int> LandmarkIndex::Lists::Of(int list) const {
  const auto begin = static_cast<std::size_t>(begins_[static_cast<std::size_t>(list)]);
  const auto end = static_cast<std::size_t>(begins_[static_cast<std::size_t>(list) + 1]);
  return std::span(items_).subspan(begin, end - begin);
}

LandmarkIndex::LandmarkIndex(const LocalizeOptions& options,
                             const LandmarkMap& map,
                             const Vocabulary& vocabulary)
    : options_(options),
      map_(map),
      vocabulary_(vocabulary),
      max_distance_(DistanceFromRelative(map.kind, options.max_descriptor_distance)),
      at_search_level_(vocabulary.tree.NumNodes(),
                       WordsAtLevel(map, std::min(options.search_level, map.num_word_levels))),
      at_leaves_(vocabulary.tree.NumNodes(), WordsAtLevel(map, map.num_word_levels)),
      keyframe_landmarks_(map.KeyframeLandmarks()),
      descriptor_offsets_(map.DescriptorOffsets()),
      frame_keyframes_(vocabulary.inverted_file.Words().size(), -1),
      spatial_tree_(std::make_unique<SpatialTree>(map.positions_in_map)) {
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const auto frame = static_cast<std::size_t>(map.keyframes[i].frame_idx);
    if (frame < frame_keyframes_.size()) frame_keyframes_[frame] = static_cast<int>(i);
  }
}

LandmarkIndex::~LandmarkIndex() = default;

const std::uint8_t* LandmarkIndex::Descriptor(const FrameFeatures& features, int feature) const {
  return &features.descriptors[static_cast<std::size_t>(feature) *
                               static_cast<std::size_t>(DescriptorSize(map_.kind))];
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

std::optional<LandmarkMatch> LandmarkIndex::Match(const FrameFeatures& features,
                                                  int feature,
                                                  std::span<const int> candidates) const {
  const std::uint8_t* descriptor = Descriptor(features, feature);
  std::vector<int> distances(candidates.size());
  LandmarkMatch best{feature, -1, kFar};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    distances[i] = DescriptorDistance(map_.kind, descriptor, map_.Descriptor(candidates[i]));
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
