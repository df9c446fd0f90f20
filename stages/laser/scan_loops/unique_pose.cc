// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/unique_pose.h"

namespace nightmap {

std::optional<BestPoses> SearchBestPoses(const FieldPyramid& pyramid,
                                         const std::vector<Eigen::Vector2d>& points_in_robot,
                                         const SearchWindow& window,
                                         double max_second_ratio) {
  const auto best = SearchPose(pyramid, points_in_robot, window);
  if (!best) return std::nullopt;
  SearchWindow elsewhere = window;
  elsewhere.not_near = best->field_from_robot;
  elsewhere.near_m = kSamePlace_m;
  elsewhere.near_rad = kSamePlace_rad;
  elsewhere.min_value = max_second_ratio * best->score;
  return BestPoses{*best, SearchPose(pyramid, points_in_robot, elsewhere)};
}

}  // namespace nightmap
