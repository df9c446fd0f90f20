// SPDX-License-Identifier: Apache-2.0
// The anchors of CeilingFilter: places that the robot left, and loops between them.
#include <Eigen/Cholesky>

#include "pipeline/ceiling/planar_pose.h"
#include "stages/ceiling/ceiling_ekf/ceiling_filter.h"
#include "stages/ceiling/ceiling_ekf/sparse_rows.h"

namespace nightmap {

void CeilingFilter::MoveAnchor() {
  const Eigen::Index n = filter_.NumActive();
  const Eigen::VectorXd& state = filter_.Active();
  const Eigen::Vector3d robot = state.segment<3>(kRobot);
  Eigen::VectorXd mean(n + 3);
  mean << state, state.segment<3>(kAnchor);
  SparseRowsBuilder jacobian(n + 3, n), noise(n + 3, n + 3);
  // The old anchor goes to the end, to be kept.
  jacobian.Identity(n, 3, kAnchor);
  mean.segment<3>(kAnchor) = Compose(state.segment<3>(kAnchor), robot).pose;
  const ComposedPose moved = Compose(state.segment<3>(kAnchor), robot_linearized_at_);
  jacobian.Add(kAnchor, kAnchor, moved.by_first);
  jacobian.Add(kAnchor, kRobot, moved.by_second);
  mean.segment<3>(kRobot).setZero();
  noise.Add(kRobot, kRobot, kExactVariance * Eigen::Matrix3d::Identity());
  jacobian.Identity(kVibration, kNumFixed - kVibration);
  for (Part& clone : clones_) {
    mean.segment<3>(clone.first) = Between(robot, state.segment<3>(clone.first)).pose;
    const ComposedPose seen = Between(robot_linearized_at_, clone.linearized_at);
    clone.linearized_at = seen.pose;
    jacobian.Add(clone.first, kRobot, seen.by_first);
    jacobian.Add(clone.first, clone.first, seen.by_second);
    jacobian.Identity(clone.first + 3, 2);
  }
  for (Part& landmark : landmarks_) {
    mean.segment<3>(landmark.first) = PointFrom(robot, state.segment<3>(landmark.first)).point;
    const SeenPoint seen = PointFrom(robot_linearized_at_, landmark.linearized_at);
    landmark.linearized_at = seen.point;
    jacobian.Add(landmark.first, kRobot, seen.by_pose);
    jacobian.Add(landmark.first, landmark.first, seen.by_point);
  }
  robot_linearized_at_.setZero();
  filter_.Transform(std::move(mean), jacobian.Build(), noise.Build());
  filter_.Keep(n, 3);
}

Rigid2 CeilingFilter::MapFromAnchor(int anchor) {
  const Eigen::VectorXd& kept = filter_.Kept();
  return ToRigid2(3 * anchor < kept.size() ? Eigen::Vector3d(kept.segment<3>(3 * anchor))
                                           : Eigen::Vector3d(filter_.Active().segment<3>(kAnchor)));
}

Eigen::Matrix3d CeilingFilter::AnchorCovariance(int anchor) {
  if (3 * anchor < filter_.NumKept()) return filter_.KeptCovariance(3 * anchor, 3);
  return filter_.ActiveCovariance().block<3, 3>(kAnchor, kAnchor);
}

Eigen::Matrix3d CeilingFilter::RelativeCovariance(int anchor) {
  const ComposedPose seen =
      Between(filter_.Active().segment<3>(kAnchor), filter_.Kept().segment<3>(3 * anchor));
  const Eigen::Matrix3d cross = filter_.CrossCovariance().block<3, 3>(kAnchor, 3 * anchor);
  const Eigen::Matrix3d mixed = seen.by_first * cross * seen.by_second.transpose();
  return seen.by_first * filter_.ActiveCovariance().block<3, 3>(kAnchor, kAnchor) *
             seen.by_first.transpose() +
         seen.by_second * AnchorCovariance(anchor) * seen.by_second.transpose() + mixed +
         mixed.transpose();
}

Innovation CeilingFilter::CloseLoop(int anchor,
                                    const Rigid2& last_from_anchor,
                                    const Eigen::Matrix3d& covariance) {
  const ComposedPose seen =
      Between(filter_.Active().segment<3>(kAnchor), filter_.Kept().segment<3>(3 * anchor));
  Eigen::Vector3d residual = ToVector(last_from_anchor) - seen.pose;
  residual.z() = WrapAngle_rad(residual.z());
  // Residuals of unit variance.
  const Eigen::Matrix3d whiten = covariance.llt().matrixL().solve(Eigen::Matrix3d::Identity());
  SparseRowsBuilder active(3, filter_.NumActive()), kept(3, filter_.NumKept());
  active.Add(0, kAnchor, whiten * seen.by_first);
  kept.Add(0, 3 * anchor, whiten * seen.by_second);
  return filter_.Update({active.Build(), whiten * residual, Eigen::Vector3d::Ones()}, kept.Build());
}

}  // namespace nightmap
