// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/bundle_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <memory>

#include "pipeline/base/error.h"
#include "pipeline/geometry/observation_error.h"

namespace nightmap {
namespace {

void CheckSizes(const BundleProblem& problem) {
  const std::size_t num_poses = problem.camera_from_world.size();
  if (problem.cameras.size() != num_poses || problem.is_fixed.size() != num_poses) {
    throw DataError("bundle adjustment: {} poses, {} cameras, {} flags",
                    num_poses,
                    problem.cameras.size(),
                    problem.is_fixed.size());
  }
  const auto& scale_idx = problem.depth_scale_idx;
  const auto num_scales = static_cast<int>(problem.depth_scales.size());
  if (num_scales == 0 || (!scale_idx.empty() && scale_idx.size() != num_poses) ||
      std::ranges::any_of(scale_idx, [&](int i) { return i < 0 || i >= num_scales; })) {
    throw DataError(
        "bundle adjustment: {} depth scales do not fit {} poses", num_scales, num_poses);
  }
}

double& DepthScale(std::size_t pose, BundleProblem* data) {
  if (data->depth_scale_idx.empty()) return data->depth_scales[0];
  return data->depth_scales[static_cast<std::size_t>(data->depth_scale_idx[pose])];
}

// A wrong match may put a point behind a camera that sees it; no step could start from there.
void DropUnseeable(BundleProblem* data) {
  std::erase_if(data->observations, [&](const BundleObservation& observation) {
    const Eigen::Vector3d p =
        data->camera_from_world[static_cast<std::size_t>(observation.pose_idx)] *
        data->points_in_world[static_cast<std::size_t>(observation.point_idx)];
    return !(p.z() >= ObservationError::kMinDepth_m);
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
        data->points_in_world[static_cast<std::size_t>(observation.point_idx)].data(),
        &DepthScale(pose, data));
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
  for (double& scale : data->depth_scales) {
    if (problem.HasParameterBlock(&scale)) ordering->AddElementToGroup(&scale, 1);
  }
  return ordering;
}

void HoldDepthScales(bool all, BundleProblem* data, ceres::Problem* problem) {
  for (double& scale : data->depth_scales) {
    const bool is_held = all || &scale == &data->depth_scales[0];
    if (is_held && problem->HasParameterBlock(&scale)) problem->SetParameterBlockConstant(&scale);
  }
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
  HoldDepthScales(!options.estimate_depth_scales, data, &problem);
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
