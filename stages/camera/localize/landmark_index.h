// SPDX-License-Identifier: Apache-2.0
// The landmark map, indexed for search by word, by keyframe and by place.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/camera/vocabulary_io.h"
#include "pipeline/io/landmarks_io.h"
#include "stages/camera/localize/localize.h"
#include "stages/camera/localize/word_index.h"

namespace nightmap {

struct LandmarkMatch {
  int feature = 0;
  int landmark = 0;
  int distance = 0;  // from DescriptorDistance

  bool operator==(const LandmarkMatch&) const = default;
};

// Keeps the most similar first (ties: lower feature, lower landmark), and each feature and each
// landmark once.
std::vector<LandmarkMatch> KeepOneToOne(std::vector<LandmarkMatch> matches);

// Const after construction: threads may share one index. Keeps references.
class LandmarkIndex {
 public:
  LandmarkIndex(const LocalizeOptions& options,
                const LandmarkMap& map,
                const VocabularyIndex& vocabulary);
  ~LandmarkIndex();

  const LandmarkMap& Map() const { return map_; }
  const VocabularyTree& Tree() const { return vocabulary_.tree; }
  const InvertedFile& Frames() const { return vocabulary_.frames; }
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

  // Descriptors under a vocabulary node.
  WordIndex::Block OfWord(int word) const { return words_.Of(word); }
  // The word in which to look for landmarks like a descriptor: its word at the search level, or a
  // deeper one if that has more than max_word_descriptors. So the cost of a feature does not grow
  // with the map.
  int SearchWord(const std::uint8_t* descriptor) const;
  // Range [first, end) of a landmark's descriptors.
  std::pair<int, int> DescriptorsOf(int landmark) const;
  std::vector<int> DescriptorsOf(const std::vector<int>& landmarks) const;
  // Landmarks that any of the keyframes sees, ascending.
  std::vector<int> LandmarksOf(const std::vector<int>& keyframes) const;
  // Keyframe of a frame, or -1.
  int KeyframeOf(int frame_idx) const;
  // The `count` landmarks nearest to a landmark in space, without itself, nearest first.
  std::vector<int> Nearest(int landmark, int count) const;

  // Distance to the most similar descriptor of a landmark.
  int Distance(const std::uint8_t* descriptor, int landmark) const;
  // Distance to each descriptor of a word.
  std::vector<int> Distances(const std::uint8_t* descriptor, const WordIndex::Block& word) const;
  // Linear search with a ratio test against the best candidate at another point in space. Where no
  // such candidate exists, the distance alone decides. Candidates are descriptors of the map.
  std::optional<LandmarkMatch> Match(const FrameFeatures& features,
                                     int feature,
                                     std::span<const int> candidates) const;
  std::optional<LandmarkMatch> MatchInWord(const FrameFeatures& features,
                                           int feature,
                                           int word) const;

 private:
  struct SpatialTree;

  std::optional<LandmarkMatch> Best(int feature,
                                    std::span<const int> candidates,
                                    const std::vector<int>& distances) const;

  const LocalizeOptions& options_;
  const LandmarkMap& map_;
  const VocabularyIndex& vocabulary_;
  int max_distance_;
  WordIndex words_;
  std::vector<std::vector<int>> keyframe_landmarks_;
  std::vector<int> descriptor_offsets_;
  std::vector<int> frame_keyframes_;  // frame_idx -> keyframe, or -1
  std::unique_ptr<SpatialTree> spatial_tree_;
};

}  // namespace nightmap
