// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/match_scan.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/input_error.h"
#include "pipeline/laser/match_cost.h"
#include "pipeline/laser/search_pose.h"

namespace nightmap {
namespace {

constexpr double kWindowSigmas = 3;
constexpr int kMaxIterations = 30;

double FarthestDistance_m(const std::vector<Eigen::Vector2d>& points) {
  double farthest_m = 0;
  for (const Eigen::Vector2d& point : points) farthest_m = std::max(farthest_m, point.norm());
  return farthest_m;
}

using Pose = std::array<double, 3>;  // x, y, heading

Eigen::Vector3d SigmasOf(const PosePrior& prior) {
  return {prior.sigma_m, prior.sigma_m, prior.sigma_rad};
}

// Minus the logarithm of the pose's likelihood.
class Surprise {
 public:
  Surprise(const LikelihoodField& field,
           const std::vector<Eigen::Vector2d>& points,
           const PosePrior& prior,
           const Rigid2& start,
           const Constraints& constraints)
      : cost_(field, points, prior, start, constraints), residuals_(points.size() + 4) {}

  double At(const Eigen::Vector3d& pose) {
    cost_(pose.data(), residuals_.data());
    double sum = 0;
    for (const double residual : residuals_) sum += 0.5 * residual * residual;
    return sum;
  }

 private:
  MatchCost cost_;
  std::vector<double> residuals_;
};

// The curvature of the surprise, over a cell or what turns the farthest point so far, in units of
// the prior's sigmas: the prior's own is 1.
Eigen::Matrix3d CurvatureAt(const LikelihoodField& field,
                            const std::vector<Eigen::Vector2d>& points,
                            const PosePrior& prior,
                            const Rigid2& pose,
                            const Constraints& constraints) {
  const double cell_m = field.Resolution_m();
  const Eigen::Vector3d steps(
      cell_m, cell_m, cell_m / std::max(cell_m, FarthestDistance_m(points)));
  const Eigen::Vector3d mean(pose.translation.x(), pose.translation.y(), pose.heading_rad);
  Surprise surprise(field, points, prior, pose, constraints);
  const auto at = [&](double x, double y, double heading) {
    return surprise.At(mean + steps.cwiseProduct(Eigen::Vector3d(x, y, heading)));
  };
  Eigen::Matrix3d curvature;  // per step
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d a = Eigen::Vector3d::Unit(i), b = Eigen::Vector3d::Unit(j);
      const auto value = [&](double along_a, double along_b) {
        const Eigen::Vector3d step = along_a * a + along_b * b;
        return at(step.x(), step.y(), step.z());
      };
      curvature(i, j) = (value(0.5, 0.5) - value(0.5, -0.5) - value(-0.5, 0.5) + value(-0.5, -0.5));
    }
  }
  const Eigen::Vector3d to_sigmas = SigmasOf(prior).cwiseQuotient(steps);
  const Eigen::Matrix3d scaled = to_sigmas.asDiagonal() * curvature * to_sigmas.asDiagonal();
  return (scaled + scaled.transpose()) / 2;
}

// The inverse curvature. Where it is less curved than the prior, what is known is the prior.
Eigen::Matrix3d CovarianceOf(const Eigen::Matrix3d& curvature, const PosePrior& prior) {
  const Eigen::Vector3d sigmas = SigmasOf(prior);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(curvature);
  const Eigen::Vector3d variances = solver.eigenvalues().cwiseMax(1.0).cwiseInverse();
  const Eigen::Matrix3d covariance =
      solver.eigenvectors() * variances.asDiagonal() * solver.eigenvectors().transpose();
  return sigmas.asDiagonal() * covariance * sigmas.asDiagonal();
}

}  // namespace

Eigen::Matrix3d CovarianceInRobot(const ScanMatch& match) {
  Eigen::Matrix3d robot_from_field = Eigen::Matrix3d::Identity();
  robot_from_field.topLeftCorner<2, 2>() =
      Eigen::Rotation2Dd(-match.field_from_robot.heading_rad).toRotationMatrix();
  return robot_from_field * match.covariance * robot_from_field.transpose();
}

std::optional<Eigen::Vector2d> UnclearDirection(
    const LikelihoodField& field,
    const std::vector<Eigen::Vector2d>& points_in_robot,
    const std::vector<Eigen::Vector2d>& normals_in_robot,
    const Rigid2& field_from_robot) {
  // By a prior whose units are those in which a point that faces a direction counts 1.
  const double sigma_m = field.Sigma_m();
  const PosePrior prior{field_from_robot, sigma_m, sigma_m};
  const Eigen::Matrix3d known =
      CurvatureAt(field, points_in_robot, prior, field_from_robot, {normals_in_robot, {}}) -
      Eigen::Matrix3d::Identity();
  Eigen::Matrix2d of_position = known.topLeftCorner<2, 2>();
  if (known(2, 2) > 0) {
    of_position -= known.topRightCorner<2, 1>() * known.bottomLeftCorner<1, 2>() / known(2, 2);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(of_position);
  if (axes.eigenvalues()[0] >= kUnclearPoints) return std::nullopt;
  return axes.eigenvectors().col(0);
}

double ScoreOf(const LikelihoodField& field,
               const std::vector<Eigen::Vector2d>& points_in_robot,
               const Rigid2& field_from_robot) {
  double sum = 0;
  for (const Eigen::Vector2d& point : points_in_robot) {
    const Eigen::Vector2d cell = field.ToCells(field_from_robot * point).array().round();
    sum += field.At(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
  }
  return points_in_robot.empty() ? 0 : sum / static_cast<double>(points_in_robot.size());
}

ScanMatch RefinePose(const LikelihoodField& field,
                     const std::vector<Eigen::Vector2d>& points_in_robot,
                     const PosePrior& prior,
                     const Rigid2& start,
                     const Constraints& constraints) {
  auto* match_cost =
      new MatchCost(field, points_in_robot, prior, start, constraints);  // Ceres owns it
  const int num_residuals = match_cost->NumResiduals();
  auto* cost =
      new ceres::AutoDiffCostFunction<MatchCost, ceres::DYNAMIC, 3>(match_cost, num_residuals);
  Pose pose = {start.translation.x(), start.translation.y(), start.heading_rad};
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, pose.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = kMaxIterations;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    throw InputError({{"scans"}}, "a scan does not match: {}", summary.message);
  }
  ScanMatch match{{pose[2], {pose[0], pose[1]}}, 0, {}};
  const Rigid2& found = match.field_from_robot;
  match.covariance =
      CovarianceOf(CurvatureAt(field, points_in_robot, prior, found, constraints), prior);
  match.score = ScoreOf(field, points_in_robot, match.field_from_robot);
  return match;
}

ScanMatch MatchScan(const FieldPyramid& pyramid,
                    const std::vector<Eigen::Vector2d>& points_in_robot,
                    const PosePrior& prior) {
  SearchWindow window;
  window.center = prior.field_from_robot;
  window.half_extent_m = kWindowSigmas * prior.sigma_m;
  window.half_angle_rad = kWindowSigmas * prior.sigma_rad;
  window.penalty_per_m2 = kPriorWeight / (prior.sigma_m * prior.sigma_m);
  window.penalty_per_rad2 = kPriorWeight / (prior.sigma_rad * prior.sigma_rad);
  window.min_value = -1;
  const auto found = SearchPose(pyramid, points_in_robot, window);
  const Rigid2 start = found ? found->field_from_robot : prior.field_from_robot;
  return RefinePose(pyramid.Field(), points_in_robot, prior, start);
}

}  // namespace nightmap
