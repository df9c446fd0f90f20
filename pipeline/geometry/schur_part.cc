// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/schur_part.h"

#include <Eigen/LU>
#include <algorithm>

#include "pipeline/base/parallel.h"

namespace nightmap {

std::vector<SchurRange> CutIntoRanges(const BundleProblem& problem, std::size_t max_observations) {
  const auto& all = problem.observations;
  const std::size_t num_points = problem.points_in_world.size();
  if (!std::ranges::is_sorted(all, {}, &BundleObservation::point_idx)) {
    return {{0, all.size(), 0, num_points}};
  }
  std::vector<SchurRange> ranges(1);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_next_point = i > 0 && all[i].point_idx != all[i - 1].point_idx;
    if (is_next_point && i - ranges.back().begin >= max_observations) {
      const auto point = static_cast<std::size_t>(all[i].point_idx);
      ranges.back().end_point = point;
      ranges.push_back({i, i, point, point});
    }
    ranges.back().end = i + 1;
  }
  ranges.back().end_point = num_points;
  return ranges;
}

void SchurPart::LinearizeRange(const SchurRange& range,
                               const Linearize& linearize,
                               int num_threads) {
  range_ = range;
  linear_.resize(range.end - range.begin);
  pose_by_point_.resize(linear_.size());
  points_.resize(range.end_point - range.first_point);
  ParallelFor(
      linear_.size(), num_threads, [&](std::size_t i) { linear_[i] = linearize(range.begin + i); });
}

void SchurPart::EliminatePoints(double trust, int num_threads) {
  ParallelFor(points_.size(), num_threads, [&](std::size_t i) {
    Eliminate(trust, range_.first_point + i);
  });
}

void SchurPart::Eliminate(double trust, std::size_t point) {
  Point& block = points_[point - range_.first_point];
  const auto num_sensors = static_cast<Eigen::Index>(problem_.calibrations.size());
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  block.by_calibration.setZero(3, has_calibrations_ ? 3 * num_sensors : 0);
  block.gradient.setZero();
  for (const int o : of_point_.Of(point)) {
    const auto& [jacobian, residual] = Linear(o);
    hessian += jacobian.by_point.transpose() * jacobian.by_point;
    block.gradient += jacobian.by_point.transpose() * residual;
    pose_by_point_[static_cast<std::size_t>(o) - range_.begin] =
        jacobian.by_pose.transpose() * jacobian.by_point;
    if (!has_calibrations_) continue;
    block.by_calibration.middleCols<3>(static_cast<Eigen::Index>(
        3 * problem_.SensorOf(problem_.observations[static_cast<std::size_t>(o)]))) +=
        jacobian.by_point.transpose() * jacobian.by_calibration;
  }
  block.damping = SchurDamping<Eigen::Vector3d>(hessian.diagonal(), trust);
  hessian.diagonal() += block.damping;
  block.inverse = hessian.inverse();
}

}  // namespace nightmap
