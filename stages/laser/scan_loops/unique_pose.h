// SPDX-License-Identifier: Apache-2.0
// Whether a scan fits at one place of a window alone: two rooms that look alike tell no place.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/laser/search_pose.h"

namespace nightmap {

// Poses within both of each other are of one place.
inline constexpr double kSamePlace_m = 0.5;
inline constexpr double kSamePlace_rad = 0.3;

struct BestPoses {
  FoundPose best;
  std::optional<FoundPose> second;  // the best one of another place, above the ratio of the best
};

// The best pose above window.min_value, and the best elsewhere that scores more than
// max_second_ratio of it. None where there is no best. Deterministic.
std::optional<BestPoses> SearchBestPoses(const FieldPyramid& pyramid,
                                         const std::vector<Eigen::Vector2d>& points_in_robot,
                                         const SearchWindow& window,
                                         double max_second_ratio);

}  // namespace nightmap
