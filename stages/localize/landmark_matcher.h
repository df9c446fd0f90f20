// SPDX-License-Identifier: Apache-2.0
// Matches between the features of a picture and the landmarks of the map.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/io/features_io.h"
#include "pipeline/io/landmarks_io.h"
#include "pipeline/vision/vocabulary_io.h"
#include "stages/localize/localize.h"

namespace nightmap {

struct LandmarkMatch {
  int feature = 0;
  int landmark = 0;
  int distance = 0;  // as DescriptorDistance
};

// Const after construction: queries may share one between threads.
class LandmarkMatcher {
 public:
  LandmarkMatcher(const LocalizeOptions& options,
                  const LandmarkMap& map,
                  const Vocabulary& vocabulary);

  // 2-D to 3-D: each feature against the landmarks that share its word at search_level, features
  // with the fewest candidates first, until max_matches (prioritized search: Sattler, Leibe,
  // Kobbelt, ICCV 2011). A match passes the ratio test against the best landmark that is another
  // point in space.
  std::vector<LandmarkMatch> SearchByWords(const FrameFeatures& features) const;

  // All features against all landmarks of the keyframes that look most alike by their words.
  std::vector<LandmarkMatch> SearchByRetrieval(const FrameFeatures& features) const;

  // 3-D to 2-D: the landmarks seen together with `seen` projected with a first pose; each is
  // matched within guided_radius_px.
  std::vector<LandmarkMatch> SearchByPose(const FrameFeatures& features,
                                          const Camera& camera,
                                          const Rigid3& camera_from_map,
                                          const std::vector<int>& seen) const;

 private:
  std::optional<LandmarkMatch> MatchFeature(const std::uint8_t* descriptor,
                                            int feature,
                                            const std::vector<int>& candidates) const;
  std::vector<int> CovisibleLandmarks(const std::vector<int>& seen) const;
  std::vector<int> LandmarksOf(const std::vector<int>& keyframes) const;
  std::vector<int> DescriptorsOf(const std::vector<int>& landmarks) const;
  int DistanceToLandmark(const std::uint8_t* descriptor, int landmark) const;
  const std::uint8_t* Descriptor(const FrameFeatures& features, int feature) const;

  const LocalizeOptions& options_;
  const LandmarkMap& map_;
  const Vocabulary& vocabulary_;
  std::vector<std::vector<int>> keyframe_landmarks_;
  std::vector<int> descriptor_offsets_;
  std::vector<std::vector<int>> word_descriptors_;  // vocabulary node -> descriptors of the map
  std::vector<int> frame_keyframes_;                // frame_idx -> keyframe, or -1
  int max_distance_;
};

}  // namespace nightmap
