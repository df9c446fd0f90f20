// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/keyframe_tree.h"

#include <algorithm>
#include <limits>

#include "pipeline/ceiling/planar_pose.h"

namespace nightmap {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

// Moves a place with a frame, plus its own step against the frame's. `step`: of x, y, heading.
Eigen::Vector2d MovedAlong(const Eigen::Vector3d& frame,
                           const Eigen::Vector3d& frame_step,
                           const Eigen::Vector3d& moved_frame,
                           const Eigen::Vector2d& place,
                           const Eigen::Vector2d& step) {
  const Eigen::Vector2d away = place - frame.head<2>();
  const Eigen::Vector2d turned(-away.y(), away.x());
  const Eigen::Vector2d own = step - frame_step.head<2>() - frame_step[2] * turned;
  const Eigen::Rotation2Dd turn(moved_frame[2] - frame[2]);
  return moved_frame.head<2>() + turn * (away + own);
}

}  // namespace

std::vector<std::vector<int>> FindNeighbours(const CeilingProblem& problem,
                                             const IndexGroups& sightings_of_point,
                                             std::size_t num_keyframes) {
  std::vector<int> keyframes;
  keyframes.reserve(problem.sightings.size());
  for (const PointSighting& sighting : problem.sightings) {
    keyframes.push_back(static_cast<int>(sighting.keyframe));
  }
  const IndexGroups of_keyframe(keyframes, num_keyframes);
  std::vector<std::vector<int>> neighbours(num_keyframes);
  for (const KeyframeMotion& motion : problem.motions) {
    neighbours[motion.start].push_back(static_cast<int>(motion.start) + 1);
    neighbours[motion.start + 1].push_back(static_cast<int>(motion.start));
  }
  std::vector<int> seen_by(num_keyframes, -1);  // the last one that saw the same point
  for (std::size_t k = 0; k < num_keyframes; ++k) {
    const auto index = static_cast<int>(k);
    seen_by[k] = index;
    for (const int other : neighbours[k]) seen_by[static_cast<std::size_t>(other)] = index;
    for (const int s : of_keyframe.Of(k)) {
      for (const int o :
           sightings_of_point.Of(problem.sightings[static_cast<std::size_t>(s)].point)) {
        const int other = keyframes[static_cast<std::size_t>(o)];
        int& last = seen_by[static_cast<std::size_t>(other)];
        if (last != index) neighbours[k].push_back(other);
        last = index;
      }
    }
    std::ranges::sort(neighbours[k]);
  }
  return neighbours;
}

KeyframeTree::KeyframeTree(const std::vector<std::vector<int>>& neighbours,
                           const CeilingProblem& problem,
                           const IndexGroups& sightings_of_point,
                           std::size_t num_points) {
  std::vector<bool> is_reached(neighbours.size(), false);
  is_reached[0] = true;
  std::vector<std::size_t> reached = {0};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const int neighbour : neighbours[reached[i]]) {
      const auto child = static_cast<std::size_t>(neighbour);
      if (is_reached[child]) continue;
      is_reached[child] = true;
      edges_.emplace_back(reached[i], child);
      reached.push_back(child);
    }
  }
  for (std::size_t point = 0; point < num_points; ++point) {
    const auto seen = sightings_of_point.Of(point);
    first_keyframe_.push_back(
        seen.empty() ? kNone : problem.sightings[static_cast<std::size_t>(seen[0])].keyframe);
  }
}

CeilingUnknowns KeyframeTree::Moved(const CeilingUnknowns& unknowns,
                                    const CeilingStep& step,
                                    double length) const {
  CeilingUnknowns moved = unknowns;
  const auto along =
      [&](std::size_t frame, const Eigen::Vector2d& place, const Eigen::Vector2d& place_step) {
        return MovedAlong(unknowns.keyframes[frame].head<3>(),
                          length * step.keyframes[frame].head<3>(),
                          moved.keyframes[frame].head<3>(),
                          place,
                          place_step);
      };
  for (std::size_t k = 0; k < moved.keyframes.size(); ++k)
    moved.keyframes[k] += length * step.keyframes[k];
  for (const auto& [parent, child] : edges_) {
    moved.keyframes[child].head<2>() = along(
        parent, unknowns.keyframes[child].head<2>(), length * step.keyframes[child].head<2>());
  }
  for (std::size_t i = 0; i < moved.points.size(); ++i) {
    moved.points[i] += length * step.points[i];
    if (first_keyframe_[i] == kNone) continue;
    moved.points[i].head<2>() =
        along(first_keyframe_[i], unknowns.points[i].head<2>(), length * step.points[i].head<2>());
  }
  moved.mounting += length * step.mounting;
  moved.wheels += length * step.wheels;
  moved.level_m += length * step.level_m;
  return moved;
}

}  // namespace nightmap
