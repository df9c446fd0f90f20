// SPDX-License-Identifier: Apache-2.0
// Matches features of a picture to landmarks of the map by visual words.
#pragma once

#include <cstdint>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "pipeline/io/features_io.h"
#include "stages/camera/localize/landmark_index.h"
#include "stages/camera/localize/localize.h"

namespace nightmap {

// Searches for one picture until options.max_matches features are matched (search = "tree" uses all
// features). The cheapest step is next; the cost of a feature is the number of descriptors it is
// compared with.
//
// 2-D to 3-D: compares a feature with the landmarks of its word (LandmarkIndex::SearchWord). 3-D to
// 2-D: compares a landmark with the features of its words at landmark_level. combined: starts with
// 2-D to 3-D; each match queues the landmarks nearest to it in space (only those that some keyframe
// sees together with it) for 3-D to 2-D, either at once, as published, or by their cost. tree:
// takes each feature down the vocabulary tree, best branch first.
class ActiveSearch {
 public:
  ActiveSearch(const LocalizeOptions& options,
               const LandmarkIndex& index,
               const FrameFeatures& features);
  std::vector<LandmarkMatch> Run();

 private:
  struct Step {
    int cost = 0;
    int order = 0;  // at equal cost the lower goes first
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
  std::vector<int> feature_words_;                           // from SearchWord
  std::unordered_map<int, std::vector<int>> word_features_;  // at landmark_level
  std::vector<bool> is_matched_;                             // by feature
  std::vector<bool> is_queued_;                              // by landmark
  std::vector<LandmarkMatch> matches_;
};

}  // namespace nightmap
