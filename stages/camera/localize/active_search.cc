// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/active_search.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "pipeline/camera/descriptor_distance.h"

namespace nightmap {
namespace {

constexpr int kNumTreeChecks = 200;  // descriptors compared per feature with search = tree
// Features within this distance are no rivals in the ratio test.
constexpr double kSamePoint_px = 5.0;

}  // namespace

ActiveSearch::ActiveSearch(const LocalizeOptions& options,
                           const LandmarkIndex& index,
                           const FrameFeatures& features)
    : options_(options),
      index_(index),
      features_(features),
      is_matched_(static_cast<std::size_t>(features.NumFeatures()), false),
      is_queued_(static_cast<std::size_t>(index.Map().NumLandmarks()), false) {}

std::vector<LandmarkMatch> ActiveSearch::Run() {
  if (options_.search == "tree") return KeepOneToOne(SearchTree());
  if (options_.search != "2d_to_3d") {
    for (int i = 0; i < features_.NumFeatures(); ++i) {
      word_features_[index_.Tree().Word(index_.Descriptor(features_, i), options_.landmark_level)]
          .push_back(i);
    }
  }
  if (options_.search == "3d_to_2d") {
    QueueLandmarks();
  } else {
    QueueFeatures();
  }
  while (!steps_.empty() && static_cast<int>(matches_.size()) < options_.max_matches) {
    const Step step = steps_.top();
    steps_.pop();
    if (step.is_landmark) {
      TryLandmark(step.item);
    } else {
      TryFeature(step.item);
    }
  }
  return KeepOneToOne(std::move(matches_));
}

void ActiveSearch::Queue(int cost, bool is_landmark, int item) {
  steps_.push({cost, num_steps_++, is_landmark, item});
}

void ActiveSearch::QueueFeatures() {
  for (int i = 0; i < features_.NumFeatures(); ++i) {
    feature_words_.push_back(index_.SearchWord(index_.Descriptor(features_, i)));
    const int cost = index_.OfWord(feature_words_.back()).Size();
    if (cost > 0) Queue(cost, false, i);
  }
}

// Landmarks that most keyframes see come first, because they are the likeliest to be seen again.
void ActiveSearch::QueueLandmarks() {
  const auto& seen_by = index_.Map().landmark_keyframes;
  for (int i = 0; i < index_.Map().NumLandmarks(); ++i) {
    const auto num_keyframes = static_cast<int>(seen_by[static_cast<std::size_t>(i)].size());
    Queue(-num_keyframes, true, i);
  }
}

std::vector<int> ActiveSearch::FeaturesLike(int landmark) const {
  std::vector<int> features;
  const auto [begin, end] = index_.DescriptorsOf(landmark);
  const int level = std::min(options_.landmark_level, index_.Map().num_word_levels);
  for (int i = begin; i < end; ++i) {
    const auto found = word_features_.find(index_.Map().Word(i, level));
    if (found == word_features_.end()) continue;
    features.insert(features.end(), found->second.begin(), found->second.end());
  }
  std::ranges::sort(features);
  features.erase(std::unique(features.begin(), features.end()), features.end());
  return features;
}

bool ActiveSearch::AreCovisible(int landmark_a, int landmark_b) const {
  const std::vector<int>& a = index_.KeyframesOf(landmark_a);
  const std::vector<int>& b = index_.KeyframesOf(landmark_b);
  return std::ranges::any_of(a,
                             [&](int keyframe) { return std::ranges::binary_search(b, keyframe); });
}

void ActiveSearch::QueueNeighbours(int landmark) {
  for (const int near : index_.Nearest(landmark, options_.num_nearest_landmarks)) {
    const auto i = static_cast<std::size_t>(near);
    if (is_queued_[i] || (options_.covisibility_filter && !AreCovisible(landmark, near))) continue;
    is_queued_[i] = true;
    const auto cost = static_cast<int>(FeaturesLike(near).size());
    if (cost > 0) Queue(options_.prioritized ? cost : 0, true, near);
  }
}

void ActiveSearch::TryFeature(int feature) {
  if (is_matched_[static_cast<std::size_t>(feature)]) return;
  const int word = feature_words_[static_cast<std::size_t>(feature)];
  const auto match = index_.MatchInWord(features_, feature, word);
  if (!match) return;
  is_matched_[static_cast<std::size_t>(feature)] = true;
  matches_.push_back(*match);
  if (options_.search == "combined") QueueNeighbours(match->landmark);
}

void ActiveSearch::TryLandmark(int landmark) {
  const std::vector<int> candidates = FeaturesLike(landmark);
  LandmarkMatch best{-1, landmark, std::numeric_limits<int>::max()};
  std::vector<int> distances;
  for (const int feature : candidates) {
    distances.push_back(index_.Distance(index_.Descriptor(features_, feature), landmark));
    if (distances.back() < best.distance) best = {feature, landmark, distances.back()};
  }
  if (best.distance > index_.MaxDistance()) return;
  const auto& pixels = features_.keypoints_px;
  int second = index_.MaxDistance();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto apart = pixels[static_cast<std::size_t>(candidates[i])] -
                       pixels[static_cast<std::size_t>(best.feature)];
    if (apart.norm() > kSamePoint_px) second = std::min(second, distances[i]);
  }
  const auto kind = index_.Map().kind;
  if (!PassesRatioTest(kind, best.distance, second, options_.max_landmark_ratio)) return;
  if (is_matched_[static_cast<std::size_t>(best.feature)]) return;
  is_matched_[static_cast<std::size_t>(best.feature)] = true;
  matches_.push_back(best);
}

std::vector<LandmarkMatch> ActiveSearch::SearchTree() const {
  const VocabularyTree& tree = index_.Tree();
  std::vector<LandmarkMatch> matches;
  for (int feature = 0; feature < features_.NumFeatures(); ++feature) {
    std::vector<int> candidates;
    tree.VisitLeaves(index_.Descriptor(features_, feature), [&](int leaf) {
      const auto found = index_.OfWord(leaf).rows;
      candidates.insert(candidates.end(), found.begin(), found.end());
      return static_cast<int>(candidates.size()) < kNumTreeChecks;
    });
    const auto match = index_.Match(features_, feature, candidates);
    if (match) matches.push_back(*match);
  }
  return matches;
}

}  // namespace nightmap
