// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/bundle_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <memory>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr double kMinDepth_m = 0.05;  // nearer, or behind the camera, a projection means nothing

// Residuals (pixel x, pixel y, depth) of one observation over their standard deviations.
// Parameters: rotation (x y z w) and translation of camera_from_world, point in the world.
class ObservationError : public ceres::SizedCostFunction<3, 4, 3, 3> {
 public:
  ObservationError(const BundleObservation& observation,
                   const Camera& camera,
                   double pixel_sigma_px)
      : observation_(observation),
        camera_(camera),
        pixel_weight_(1 / pixel_sigma_px),
        depth_weight_(observation.depth_m > 0 ? 1 / observation.noise.Sigma_m(observation.depth_m)
                                              : 0.0) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Quaterniond> rotation(parameters[0]);
    const Eigen::Map<const Eigen::Vector3d> translation(parameters[1]);
    const Eigen::Map<const Eigen::Vector3d> point(parameters[2]);
    const Eigen::Vector3d rotated = rotation * point;
    const Eigen::Vector3d p = rotated + translation;
    if (p.z() < kMinDepth_m) return false;  // Ceres takes a shorter step
    residuals[0] =
        pixel_weight_ * (camera_.fx * p.x() / p.z() + camera_.cx - observation_.pixel.x());
    residuals[1] =
        pixel_weight_ * (camera_.fy * p.y() / p.z() + camera_.cy - observation_.pixel.y());
    residuals[2] = depth_weight_ * (p.z() - observation_.depth_m);
    if (jacobians) FillJacobians(p, rotation, point, jacobians);
    return true;
  }

 private:
  void FillJacobians(const Eigen::Vector3d& p,
                     const Eigen::Quaterniond& rotation,
                     const Eigen::Vector3d& point,
                     double** jacobians) const {
    Eigen::Matrix3d by_p;
    by_p << camera_.fx / p.z(), 0, -camera_.fx * p.x() / (p.z() * p.z()),  //
        0, camera_.fy / p.z(), -camera_.fy * p.y() / (p.z() * p.z()),      //
        0, 0, 1;
    by_p.row(0) *= pixel_weight_;
    by_p.row(1) *= pixel_weight_;
    by_p.row(2) *= depth_weight_;
    if (jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> by_rotation(jacobians[0]);
      by_rotation = by_p * RotationJacobian(rotation, point);
    }
    if (jacobians[1]) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> by_translation(jacobians[1]);
      by_translation = by_p;
    }
    if (jacobians[2]) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> by_point(jacobians[2]);
      by_point = by_p * rotation.toRotationMatrix();
    }
  }

  // Derivative of q * x by (qx, qy, qz, qw), from q * x = x + 2 w (v cross x) + 2 v cross (v cross
  // x), the form Eigen evaluates.
  static Eigen::Matrix<double, 3, 4> RotationJacobian(const Eigen::Quaterniond& q,
                                                      const Eigen::Vector3d& x) {
    const Eigen::Vector3d v = q.vec();
    const Eigen::Matrix3d outer = v * x.transpose();
    Eigen::Matrix<double, 3, 4> jacobian;
    jacobian.leftCols<3>() = 2 * (-q.w() * Skew(x) + v.dot(x) * Eigen::Matrix3d::Identity() +
                                  outer - 2 * x * v.transpose());
    jacobian.rightCols<1>() = 2 * v.cross(x);
    return jacobian;
  }

  BundleObservation observation_;
  Camera camera_;
  double pixel_weight_;
  double depth_weight_;
};

void CheckSizes(const BundleProblem& problem) {
  const std::size_t num_poses = problem.camera_from_world.size();
  if (problem.cameras.size() != num_poses || problem.is_fixed.size() != num_poses) {
    throw DataError("bundle adjustment: {} poses, {} cameras, {} flags",
                    num_poses,
                    problem.cameras.size(),
                    problem.is_fixed.size());
  }
}

// A wrong match may put a point behind a camera that sees it; no step could start from there.
void DropUnseeable(BundleProblem* data) {
  std::erase_if(data->observations, [&](const BundleObservation& observation) {
    const Eigen::Vector3d p =
        data->camera_from_world[static_cast<std::size_t>(observation.pose_idx)] *
        data->points_in_world[static_cast<std::size_t>(observation.point_idx)];
    return !(p.z() >= kMinDepth_m);
  });
}

void AddObservations(const BundleOptions& options, BundleProblem* data, ceres::Problem* problem) {
  for (const BundleObservation& observation : data->observations) {
    const auto pose = static_cast<std::size_t>(observation.pose_idx);
    Rigid3& camera_from_world = data->camera_from_world[pose];
    problem->AddResidualBlock(
        new ObservationError(observation, data->cameras[pose], options.pixel_sigma_px),
        new ceres::HuberLoss(options.robust_scale),
        camera_from_world.rotation.coeffs().data(),
        camera_from_world.translation.data(),
        data->points_in_world[static_cast<std::size_t>(observation.point_idx)].data());
  }
}

// Points first, then poses: the elimination order that makes the Schur complement small.
std::shared_ptr<ceres::ParameterBlockOrdering> MakeOrdering(BundleProblem* data,
                                                            const ceres::Problem& problem) {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (Eigen::Vector3d& point : data->points_in_world) {
    if (problem.HasParameterBlock(point.data())) ordering->AddElementToGroup(point.data(), 0);
  }
  for (Rigid3& pose : data->camera_from_world) {
    if (!problem.HasParameterBlock(pose.translation.data())) continue;
    ordering->AddElementToGroup(pose.rotation.coeffs().data(), 1);
    ordering->AddElementToGroup(pose.translation.data(), 1);
  }
  return ordering;
}

void SetManifolds(BundleProblem* data, ceres::Problem* problem) {
  for (std::size_t i = 0; i < data->camera_from_world.size(); ++i) {
    Rigid3& pose = data->camera_from_world[i];
    if (!problem->HasParameterBlock(pose.translation.data())) continue;
    problem->SetManifold(pose.rotation.coeffs().data(), new ceres::EigenQuaternionManifold);
    if (!data->is_fixed[i]) continue;
    problem->SetParameterBlockConstant(pose.rotation.coeffs().data());
    problem->SetParameterBlockConstant(pose.translation.data());
  }
}

}  // namespace

BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem* data) {
  CheckSizes(*data);
  DropUnseeable(data);
  if (data->observations.empty()) return {};
  ceres::Problem problem;
  AddObservations(options, data, &problem);
  SetManifolds(data, &problem);
  ceres::Solver::Options solver_options;
  solver_options.linear_solver_type = ceres::SPARSE_SCHUR;
  solver_options.linear_solver_ordering = MakeOrdering(data, problem);
  solver_options.max_num_iterations = options.max_iterations;
  solver_options.function_tolerance = 1e-5;
  solver_options.max_num_consecutive_invalid_steps = 30;  // each is shorter than the one before
  solver_options.num_threads = 1;  // parallel sums would make the result depend on the schedule
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    throw DataError("bundle adjustment failed: {}", summary.message);
  }
  for (Rigid3& pose : data->camera_from_world) pose.rotation.normalize();
  return {summary.initial_cost, summary.final_cost, static_cast<int>(summary.iterations.size())};
}

}  // namespace nightmap
