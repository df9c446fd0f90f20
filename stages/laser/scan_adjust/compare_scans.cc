// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/compare_scans.h"

#include <Eigen/Geometry>

namespace nightmap {
namespace {

constexpr double kMinCosine = 0.9;  // between the normals of a match

Eigen::Vector2d QuarterTurn(const Eigen::Vector2d& vector) { return {-vector.y(), vector.x()}; }

// The points as columns, for fast search.
Eigen::Matrix2Xd Columns(const std::vector<WallPoint>& points) {
  Eigen::Matrix2Xd columns(2, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = points[i].point_in_robot;
  }
  return columns;
}

}  // namespace

PairEquations CompareScans(const std::vector<WallPoint>& scan,
                           const Rigid2& scan_pose,
                           const std::vector<WallPoint>& target,
                           const Rigid2& target_pose,
                           double gate_m,
                           double sigma_m) {
  PairEquations equations;
  if (target.empty()) return equations;
  const Eigen::Matrix2Xd columns = Columns(target);
  const Rigid2 target_from_scan = target_pose.Inverse() * scan_pose;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(target_from_scan.heading_rad).matrix();
  const Eigen::Matrix2d graph_from_target = Eigen::Rotation2Dd(target_pose.heading_rad).matrix();
  for (const WallPoint& point : scan) {
    const Eigen::Vector2d in_target = turn * point.point_in_robot + target_from_scan.translation;
    Eigen::Index nearest = 0;
    const double distance_m2 =
        (columns.colwise() - in_target).colwise().squaredNorm().minCoeff(&nearest);
    if (distance_m2 > gate_m * gate_m) continue;
    const WallPoint& wall = target[static_cast<std::size_t>(nearest)];
    if ((turn * point.normal_in_robot).dot(wall.normal_in_robot) < kMinCosine) continue;
    const double off_m = wall.normal_in_robot.dot(in_target - wall.point_in_robot);
    // In the graph's axes. Turning the target turns its wall, too, about the target.
    const Eigen::Vector2d normal = graph_from_target * wall.normal_in_robot;
    const Eigen::Vector2d from_scan =
        graph_from_target * (in_target - target_from_scan.translation);
    const Eigen::Vector2d from_target = graph_from_target * in_target;
    Vector6 derivatives;
    derivatives << normal, normal.dot(QuarterTurn(from_scan)), -normal,
        -normal.dot(QuarterTurn(from_target));
    const double residual = off_m / sigma_m;
    const double weight = 1 / (1 + residual * residual);
    derivatives /= sigma_m;
    equations.hessian += weight * derivatives * derivatives.transpose();
    equations.gradient += weight * residual * derivatives;
    equations.sum_squares_m2 += off_m * off_m;
    ++equations.num_matches;
  }
  return equations;
}

}  // namespace nightmap
