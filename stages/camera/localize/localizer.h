// SPDX-License-Identifier: Apache-2.0
// Searches the map, or a part of it, for the pose of one picture from its features.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/io/queries_io.h"
#include "stages/camera/localize/judge_places.h"
#include "stages/camera/localize/landmark_index.h"
#include "stages/camera/localize/localize.h"
#include "stages/camera/localize/picture_pose.h"

namespace nightmap {

struct Picture {
  const PictureLens& lens;
  const FrameFeatures& features;
  std::uint64_t random_seed;
  std::vector<Camera> starts;  // lenses to start from
};

// Keeps references.
Picture MakePicture(const LocalizeOptions& options,
                    const FrameRecord& query,
                    const PictureLens& lens,
                    const FrameFeatures& features);

// Runs active search; where that gives no pose, retrieval; then a second search around the pose
// found; then the first and the second for the mirror image, and a search for another place that
// explains the picture as well. Const after construction: threads may share one. Keeps references.
class Localizer {
 public:
  Localizer(const LocalizeOptions& options,
            const LandmarkMap& map,
            const VocabularyIndex& vocabulary)
      : options_(options), index_(options, map, vocabulary) {}

  // All of it, in a map that is whole.
  QueryResult Localize(const FrameRecord& query,
                       const PictureLens& lens,
                       const FrameFeatures& features) const;

  // Its steps, for a map in parts. Search leaves out retrieval, rivals and the mirror image.
  FoundPlaces Search(const Picture& picture) const;
  // Locates a picture by retrieval, which is slow, when it was not located.
  void Retrieve(const Picture& picture, FoundPlaces* places) const;
  std::optional<Place> SearchMirrored(const Picture& mirror_image) const;
  // The best pose in another place than the one located, if any.
  void AddRival(const Picture& picture, FoundPlaces* places) const;

 private:
  std::optional<Place> SearchAndEstimate(const Picture& picture, int* num_matches) const;
  std::optional<Place> SearchRetrieved(const Picture& picture, int* num_matches) const;
  Place SearchAround(const Picture& picture, const Place& first) const;
  std::optional<Place> SearchRival(const Picture& picture, const Place& located) const;
  std::optional<Place> Estimate(const Picture& picture,
                                const std::vector<LandmarkMatch>& matches,
                                int min_inliers) const;

  const LocalizeOptions& options_;
  LandmarkIndex index_;
};

}  // namespace nightmap
