// SPDX-License-Identifier: Apache-2.0
#include "pipeline/planar/match_scan.h"

#include <ceres/ceres.h>
#include <ceres/cubic_interpolation.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/planar/search_pose.h"

namespace nightmap {
namespace {

constexpr double kWindowSigmas = 3;
// Neighbouring points whose errors are one and the same (an edge of a chair, a shift of the clock).
// The field is wider than the noise of a scanner, so that as many points count as if they erred
// alone.
constexpr double kPointsPerError = 1;
constexpr double kSmooth = 1e-6;  // keeps the root below differentiable
constexpr int kMaxIterations = 30;

double FarthestDistance_m(const std::vector<Eigen::Vector2d>& points) {
  double farthest_m = 0;
  for (const Eigen::Vector2d& point : points) farthest_m = std::max(farthest_m, point.norm());
  return farthest_m;
}

// Residuals of all points, then of the prior. 1 - field is half the squared distance from a wall
// over its variance.
class MatchCost {
 public:
  MatchCost(const LikelihoodField& field,
            const std::vector<Eigen::Vector2d>& points,
            const PosePrior& prior)
      : field_(field), interpolator_(field), points_(points), prior_(prior) {}

  int NumResiduals() const { return static_cast<int>(points_.size()) + 3; }

  template <typename T>
  bool operator()(const T* const pose, T* residuals) const {
    const T cosine = cos(pose[2]), sine = sin(pose[2]);
    const Eigen::Vector2d origin_cells = field_.ToCells({0, 0});
    const double cells_per_m = 1 / field_.Resolution_m();
    for (const Eigen::Vector2d& point : points_) {
      const T x_m = cosine * point.x() - sine * point.y() + pose[0];
      const T y_m = sine * point.x() + cosine * point.y() + pose[1];
      T value;
      interpolator_.Evaluate(
          y_m * cells_per_m + origin_cells.y(), x_m * cells_per_m + origin_cells.x(), &value);
      const T missing = value < 1.0 ? 1.0 - value : T(0);  // the interpolation overshoots
      *residuals++ = sqrt((2.0 * missing + kSmooth) / kPointsPerError);
    }
    const Rigid2& mean = prior_.field_from_robot;
    *residuals++ = (pose[0] - mean.translation.x()) / prior_.sigma_m;
    *residuals++ = (pose[1] - mean.translation.y()) / prior_.sigma_m;
    *residuals++ = (pose[2] - mean.heading_rad) / prior_.sigma_rad;
    return true;
  }

 private:
  const LikelihoodField& field_;
  ceres::BiCubicInterpolator<LikelihoodField> interpolator_;
  const std::vector<Eigen::Vector2d>& points_;
  const PosePrior& prior_;
};

using Pose = std::array<double, 3>;  // x, y, heading

// Minus the logarithm of the pose's likelihood.
class Surprise {
 public:
  Surprise(const LikelihoodField& field,
           const std::vector<Eigen::Vector2d>& points,
           const PosePrior& prior)
      : cost_(field, points, prior), residuals_(points.size() + 3) {}

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

// The inverse curvature of the surprise, over a cell or what turns the farthest point so far. Where
// it is less curved than the prior, what is known is the prior.
Eigen::Matrix3d CovarianceAt(const LikelihoodField& field,
                             const std::vector<Eigen::Vector2d>& points,
                             const PosePrior& prior,
                             const Rigid2& pose) {
  const double cell_m = field.Resolution_m();
  const Eigen::Vector3d steps(
      cell_m, cell_m, cell_m / std::max(cell_m, FarthestDistance_m(points)));
  const Eigen::Vector3d mean(pose.translation.x(), pose.translation.y(), pose.heading_rad);
  Surprise surprise(field, points, prior);
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
  const Eigen::Vector3d sigmas(prior.sigma_m, prior.sigma_m, prior.sigma_rad);
  const Eigen::Vector3d to_sigmas = sigmas.cwiseQuotient(steps);
  // In units of the prior's sigmas its own curvature is 1.
  const Eigen::Matrix3d scaled = to_sigmas.asDiagonal() * curvature * to_sigmas.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver((scaled + scaled.transpose()) / 2);
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
                     const Rigid2& start) {
  auto* match_cost = new MatchCost(field, points_in_robot, prior);  // Ceres owns it
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
  if (!summary.IsSolutionUsable()) throw DataError("scan matching failed: {}", summary.message);
  ScanMatch match{{pose[2], {pose[0], pose[1]}}, 0, {}};
  match.covariance = CovarianceAt(field, points_in_robot, prior, match.field_from_robot);
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
