// SPDX-License-Identifier: Apache-2.0
// Matches between the features of a picture and the landmarks of the map, by visual words.
#pragma once

#include <cstdint>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "pipeline/io/features_io.h"
#include "stages/localize/landmark_index.h"
#include "stages/localize/localize.h"

namespace nightmap {

// The search of one picture, until options.max_matches features are matched (search = "tree" uses
// all features). The cheapest step is next: a feature costs the descriptors it is compared with.
//
// 2-D to 3-D: a feature against the landmarks of its word (LandmarkIndex::SearchWord).
// 3-D to 2-D: a landmark against the features of its words at landmark_level.
// combined: 2-D to 3-D, and each match brings the landmarks nearest to it in space (only those that
// some keyframe sees together with it) for 3-D to 2-D; at once, as published, or by their cost.
// tree: each feature down the vocabulary tree, best branch first.
class ActiveSearch {
 public:
  ActiveSearch(const LocalizeOptions& options,
               const LandmarkIndex& index,
               const FrameFeatures& features);
  std::vector<LandmarkMatch> Run();

 private:
  struct Step {
    int cost = 0;
    int order = 0;  // of equal cost the earlier goes first
    bool is_landmark = false;
    int item = 0;
    bool operator<(const Step& other) const {
      return std::tie(cost, order) > std::tie(other.cost, other.order);
    }
  };

  void Queue(int cost, bool is_landmark, int item);
  void QueueFeatures();
  void QueueLandmarks();
  void QueueLandmark(int landmark);
  void QueueNeighbours(int landmark);
  void TryFeature(int feature);
  void TryLandmark(int landmark);
  std::vector<int> FeaturesLike(int landmark) const;
  bool AreCovisible(int landmark_a, int landmark_b) const;
  std::vector<LandmarkMatch> SearchTree() const;

  const LocalizeOptions& options_;
  const LandmarkIndex& index_;
  const FrameFeatures& features_;
  std::priority_queue<Step> steps_;
  int num_steps_ = 0;                                        // queued so far
  std::vector<int> feature_words_;                           // as SearchWord
  std::unordered_map<int, std::vector<int>> word_features_;  // at landmark_level
  std::vector<bool> is_matched_;                             // of each feature
  std::vector<bool> is_queued_;                              // of each landmark
  std::vector<LandmarkMatch> matches_;
};

}  // namespace nightmap
