// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_match/submaps.h"

namespace nightmap {
namespace {

constexpr int kNumLevels = 6;  // squares of up to 32 cells

}  // namespace

const FieldPyramid& Submaps::PyramidOfOlder() {
  Submap& submap = submaps_.front();
  if (!submap.pyramid) submap.pyramid.emplace(submap.field, kNumLevels);
  return *submap.pyramid;
}

void Submaps::Add(const Rigid2& start_from_robot,
                  const std::vector<Eigen::Vector2d>& points_in_robot) {
  if (!IsEmpty() && submaps_.front().num_keyscans >= num_keyscans_) submaps_.pop_front();
  if (IsEmpty() || (submaps_.size() == 1 && 2 * submaps_.front().num_keyscans >= num_keyscans_)) {
    submaps_.push_back({start_from_robot, LikelihoodField(options_), 0, std::nullopt});
  }
  for (Submap& submap : submaps_) {
    const Rigid2 submap_from_robot = submap.start_from_submap.Inverse() * start_from_robot;
    std::vector<Eigen::Vector2d> points;
    points.reserve(points_in_robot.size());
    for (const Eigen::Vector2d& point : points_in_robot) {
      points.push_back(submap_from_robot * point);
    }
    submap.field.Add(points);
    submap.pyramid.reset();
    ++submap.num_keyscans;
  }
}

}  // namespace nightmap
