// SPDX-License-Identifier: Apache-2.0
#include "pipeline/planar/unique_pose.h"

namespace nightmap {

std::optional<BestPoses> SearchBestPoses(const FieldPyramid& pyramid,
                                         const std::vector<Eigen::Vector2d>& points_in_robot,
                                         SearchWindow window,
                                         double max_second_ratio) {
  const auto best = SearchPose(pyramid, points_in_robot, window);
  if (!best) return std::nullopt;
  window.not_near = best->field_from_robot;
  window.near_m = kSamePlace_m;
  window.near_rad = kSamePlace_rad;
  window.min_value = max_second_ratio * best->score;
  return BestPoses{*best, SearchPose(pyramid, points_in_robot, window)};
}

}  // namespace nightmap
