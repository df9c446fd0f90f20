// SPDX-License-Identifier: Apache-2.0
// Computes the pose of one picture from its features.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/io/queries_io.h"
#include "stages/camera/localize/landmark_index.h"
#include "stages/camera/localize/localize.h"
#include "stages/camera/localize/picture_pose.h"

namespace nightmap {

// The result row of a query that was not located.
QueryResult FailedQuery(const FrameRecord& query, QueryVerdict verdict, const std::string& reason);

// Runs active search; where that gives no pose, retrieval; then a second search around the pose
// found; then the first and the second for the mirror image, and a search for another place that
// explains the picture as well. Const after
// construction: threads may share one. Keeps references.
class Localizer {
 public:
  Localizer(const LocalizeOptions& options,
            const LandmarkMap& map,
            const VocabularyIndex& vocabulary)
      : options_(options), index_(options, map, vocabulary) {}

  QueryResult Localize(const FrameRecord& query,
                       const PictureLens& lens,
                       const FrameFeatures& features) const;

 private:
  // The current picture.
  struct Picture {
    const PictureLens& lens;
    const FrameFeatures& features;
    std::uint64_t random_seed;
    std::vector<Camera> starts;  // lenses to start from
  };
  struct Located : PicturePose {
    std::vector<LandmarkMatch> matches;
    double chance_ratio = 0;  // share of the matches that a wrong pose would have as inliers
    int NumInliers() const { return static_cast<int>(pose.inliers.size()); }
    std::vector<LandmarkMatch> Inliers() const;
    // Inliers in excess of that ratio, in standard deviations of the binomial distribution.
    double InlierSignificance() const;
  };

  std::optional<Located> SearchAndEstimate(const Picture& picture, int* num_matches) const;
  std::optional<Located> SearchRetrieved(const Picture& picture, int* num_matches) const;
  Located SearchAround(const Picture& picture, const Located& first) const;
  // The best pose in another place, if any.
  std::optional<Located> SearchRival(const Picture& picture, const Located& located) const;
  std::vector<PointMatch> Points(const Picture& picture,
                                 const std::vector<LandmarkMatch>& matches) const;
  std::optional<Located> Estimate(const Picture& picture,
                                  const std::vector<LandmarkMatch>& matches,
                                  int min_inliers) const;
  // Whether enough landmarks support the pose: more than a wrong one would have by chance.
  bool IsInMap(const Located& located) const;
  // Whether the mirror image of the picture explains it significantly better.
  bool IsMirrored(const Picture& picture, const std::optional<Located>& located) const;
  void Judge(const Picture& picture, Located located, QueryResult* result) const;
  void FillPose(const Located& located, QueryResult* result) const;

  const LocalizeOptions& options_;
  LandmarkIndex index_;
};

}  // namespace nightmap
