// SPDX-License-Identifier: Apache-2.0
// The pose of one picture from its features.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry/absolute_pose.h"
#include "pipeline/io/queries_io.h"
#include "stages/localize/landmark_matcher.h"
#include "stages/localize/localize.h"

namespace nightmap {

// The row of a query that was not located.
QueryResult FailedQuery(const FrameRecord& query, const std::string& reason);

// Search by words; where that gives no pose, by retrieval; then once more around the pose found.
// Const after construction: queries may share one between threads. Keeps references.
class Localizer {
 public:
  Localizer(const LocalizeOptions& options, const LandmarkMap& map, const Vocabulary& vocabulary)
      : options_(options), map_(map), matcher_(options, map, vocabulary) {}

  QueryResult Localize(const FrameRecord& query,
                       const Camera& camera,
                       const FrameFeatures& features) const;

 private:
  struct Located {
    AbsolutePose pose;
    std::vector<LandmarkMatch> matches;
  };
  Located Refine(const FrameFeatures& features,
                 const Camera& camera,
                 const Located& first,
                 std::uint64_t random_seed) const;
  std::optional<Located> Estimate(const FrameFeatures& features,
                                  const Camera& camera,
                                  const std::vector<LandmarkMatch>& matches,
                                  std::uint64_t random_seed,
                                  int min_inliers) const;

  const LocalizeOptions& options_;
  const LandmarkMap& map_;
  LandmarkMatcher matcher_;
};

}  // namespace nightmap
