// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/drive.h"

namespace nightmap {
namespace {

constexpr double kLost_rad2 = 0.01;  // of one motion; scans that fit tell it better

}  // namespace

DriftSums::DriftSums(const std::vector<Keyscan>& keyscans, const std::vector<SensorEdge>& edges) {
  Sums sums;
  for (std::size_t i = 0; i < keyscans.size(); ++i) {
    const Rigid2& pose = keyscans[i].start_from_robot;
    if (i > 0) {
      // An edge's covariance is along the axes of its target, which is this keyscan.
      const Eigen::Matrix2d turn = Eigen::Rotation2Dd(pose.heading_rad).toRotationMatrix();
      const Matrix6d& covariance = edges[i - 1].covariance;
      const double variance_rad2 = covariance(2, 2);
      sums.covariance_m2 += turn * covariance.block<2, 2>(3, 3) * turn.transpose();
      sums.variance_rad2 += variance_rad2;
      if (variance_rad2 > kLost_rad2) sums.lost_rad2 += variance_rad2;
      sums.moment += variance_rad2 * pose.translation;
      sums.second_moment += variance_rad2 * pose.translation * pose.translation.transpose();
    }
    places_.push_back(pose.translation);
    sums_.push_back(sums);
  }
}

Drift DriftSums::Between(std::size_t a, std::size_t b) const {
  const Sums &before = sums_[a], &all = sums_[b];
  const double variance_rad2 = all.variance_rad2 - before.variance_rad2;
  const Eigen::Vector2d moment = all.moment - before.moment;
  const Eigen::Vector2d& place = places_[b];
  // Sum over the edges of variance * (place - p) (place - p)^T.
  const Eigen::Matrix2d levers = variance_rad2 * place * place.transpose() -
                                 place * moment.transpose() - moment * place.transpose() +
                                 all.second_moment - before.second_moment;
  Eigen::Matrix2d quarter_turn;
  quarter_turn << 0, -1, 1, 0;
  return {
      all.covariance_m2 - before.covariance_m2 + quarter_turn * levers * quarter_turn.transpose(),
      variance_rad2,
      all.lost_rad2 - before.lost_rad2};
}

}  // namespace nightmap
