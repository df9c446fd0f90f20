// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/path_track.h"

#include <algorithm>
#include <limits>

namespace nightmap {

PathTrack::PathTrack(const std::vector<Eigen::Vector2d>& points) {
  for (const Eigen::Vector2d& point : points) {
    const double step_m = points_.empty() ? 0 : (point - points_.back()).norm();
    if (!points_.empty() && step_m == 0) continue;
    distances_m_.push_back(points_.empty() ? 0 : distances_m_.back() + step_m);
    points_.push_back(point);
  }
}

// Index of the segment's first point; the segment ends at the next one. Not for a track of one
// point.
std::size_t PathTrack::SegmentAt(double distance_m) const {
  const auto next = std::upper_bound(distances_m_.begin() + 1, distances_m_.end() - 1, distance_m);
  return static_cast<std::size_t>(next - distances_m_.begin()) - 1;
}

Eigen::Vector2d PathTrack::At(double distance_m) const {
  if (points_.size() == 1) return points_[0];
  const double clamped_m = std::clamp(distance_m, 0.0, Length_m());
  const std::size_t i = SegmentAt(clamped_m);
  const double part = (clamped_m - distances_m_[i]) / (distances_m_[i + 1] - distances_m_[i]);
  return points_[i] + part * (points_[i + 1] - points_[i]);
}

double PathTrack::Nearest_m(const Eigen::Vector2d& point, double from_m, double to_m) const {
  if (points_.size() == 1) return 0;
  double nearest_m = from_m;
  double squared = std::numeric_limits<double>::infinity();
  for (std::size_t i = SegmentAt(from_m); i + 1 < points_.size() && distances_m_[i] <= to_m; ++i) {
    const double length_m = distances_m_[i + 1] - distances_m_[i];
    const Eigen::Vector2d direction = (points_[i + 1] - points_[i]) / length_m;
    const double first_m = std::max(0.0, from_m - distances_m_[i]);
    const double last_m = std::max(first_m, std::min(length_m, to_m - distances_m_[i]));
    const double along_m = std::clamp((point - points_[i]).dot(direction), first_m, last_m);
    const double candidate = (points_[i] + along_m * direction - point).squaredNorm();
    if (candidate >= squared) continue;
    squared = candidate;
    nearest_m = distances_m_[i] + along_m;
  }
  return nearest_m;
}

}  // namespace nightmap
