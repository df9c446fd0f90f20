// SPDX-License-Identifier: Apache-2.0
// The landmark map, arranged for search: by word, by keyframe, by place.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/io/landmarks_io.h"
#include "pipeline/vision/vocabulary_io.h"
#include "stages/localize/localize.h"

namespace nightmap {

struct LandmarkMatch {
  int feature = 0;
  int landmark = 0;
  int distance = 0;  // as DescriptorDistance
};

// Most similar first (ties: lower feature, lower landmark); each feature and each landmark once.
std::vector<LandmarkMatch> KeepOneToOne(std::vector<LandmarkMatch> matches);

// Const after construction: queries may share one between threads. Keeps references.
class LandmarkIndex {
 public:
  LandmarkIndex(const LocalizeOptions& options,
                const LandmarkMap& map,
                const Vocabulary& vocabulary);
  ~LandmarkIndex();

  const LandmarkMap& Map() const { return map_; }
  const Vocabulary& GetVocabulary() const { return vocabulary_; }
  int MaxDistance() const { return max_distance_; }
  const Eigen::Vector3d& Position(int landmark) const {
    return map_.positions_in_map[static_cast<std::size_t>(landmark)];
  }
  const std::uint8_t* Descriptor(const FrameFeatures& features, int feature) const;
  int LandmarkOf(int descriptor) const {
    return map_.descriptor_landmarks[static_cast<std::size_t>(descriptor)];
  }
  const std::vector<int>& KeyframesOf(int landmark) const {
    return map_.landmark_keyframes[static_cast<std::size_t>(landmark)];
  }

  // Descriptors (rows of the map) under a vocabulary node of the search level, or of the leaf
  // level.
  std::span<const int> DescriptorsOfWord(int word) const { return at_search_level_.Of(word); }
  std::span<const int> DescriptorsOfLeaf(int leaf) const { return at_leaves_.Of(leaf); }
  // First descriptor of a landmark and the one after its last.
  std::pair<int, int> DescriptorsOf(int landmark) const;
  std::vector<int> DescriptorsOf(const std::vector<int>& landmarks) const;
  // Landmarks that any of the keyframes sees, ascending.
  std::vector<int> LandmarksOf(const std::vector<int>& keyframes) const;
  // Of a frame, or -1.
  int KeyframeOf(int frame_idx) const;
  // The `count` landmarks nearest to a landmark in space, itself not among them, nearest first.
  std::vector<int> Nearest(int landmark, int count) const;

  // Of the descriptor of a landmark that is nearest.
  int Distance(const std::uint8_t* descriptor, int landmark) const;
  // Linear search with ratio test against the best candidate that is another point in space; where
  // there is none, the distance must do.
  std::optional<LandmarkMatch> Match(const FrameFeatures& features,
                                     int feature,
                                     std::span<const int> candidates) const;

 private:
  // Lists of ints, one a node of the vocabulary.
  class Lists {
   public:
    Lists(int num_lists, const std::vector<int>& list_of_item);
    std::span<const int> Of(int list) const;

   private:
    std::vector<int> begins_;
    std::vector<int> items_;
  };
  struct SpatialTree;

  const LocalizeOptions& options_;
  const LandmarkMap& map_;
  const Vocabulary& vocabulary_;
  int max_distance_;
  Lists at_search_level_;
  Lists at_leaves_;
  std::vector<std::vector<int>> keyframe_landmarks_;
  std::vector<int> descriptor_offsets_;
  std::vector<int> frame_keyframes_;  // frame_idx -> keyframe, or -1
  std::unique_ptr<SpatialTree> spatial_tree_;
};

}  // namespace nightmap
