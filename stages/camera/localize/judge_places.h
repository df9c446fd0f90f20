// SPDX-License-Identifier: Apache-2.0
// Judges what parts of the map say about a picture: located, ambiguous, or not in the map.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/io/queries_io.h"
#include "stages/camera/localize/landmark_index.h"
#include "stages/camera/localize/localize.h"
#include "stages/camera/localize/picture_pose.h"

namespace nightmap {

// A pose of a picture with all that judges it: nothing of it refers to the map.
struct Place : PicturePose {
  std::vector<LandmarkMatch> matches;
  std::vector<PointMatch> points;        // of the matches
  std::vector<float> position_sigmas_m;  // of the matches' landmarks
  double chance_ratio = 0;  // share of the matches that a wrong pose would have as inliers

  int NumInliers() const { return static_cast<int>(pose.inliers.size()); }
  std::vector<LandmarkMatch> Inliers() const;
  // Inliers in excess of that ratio, in standard deviations of the binomial distribution.
  double InlierSignificance() const;
};

// Places of a picture in one part of the map.
struct FoundPlaces {
  std::optional<Place> located;
  std::optional<Place> rival;     // elsewhere in that part
  std::optional<Place> mirrored;  // of the picture's mirror image
  int num_matches = 0;
};

// Whether inliers alone do not speak against a place.
bool IsInMap(const LocalizeOptions& options, const Place& place);

// Whether two poses are one place seen once.
bool IsSameView(const LocalizeOptions& options, const Place& a, const Place& b);

// Whether the mirror image of the picture explains it significantly better.
bool IsMirrored(const LocalizeOptions& options, const FoundPlaces& places);

// The result row of a query that was not located.
QueryResult FailedQuery(const FrameRecord& query, QueryVerdict verdict, const std::string& reason);

// The place with the most inliers of all parts is the picture's, another view with the most is its
// rival; of equal ones the first.
QueryResult JudgePlaces(const LocalizeOptions& options,
                        const FrameRecord& query,
                        const PictureLens& lens,
                        std::vector<FoundPlaces> of_parts);

}  // namespace nightmap
