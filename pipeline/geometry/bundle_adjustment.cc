// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include <algorithm>
#include <array>
#include <limits>
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
  const auto& sensor_idx = problem.sensor_idx;
  const auto num_sensors = static_cast<int>(problem.calibrations.size());
  if (num_sensors == 0 || (!sensor_idx.empty() && sensor_idx.size() != num_poses) ||
      (!problem.motions.empty() && problem.motions.size() != num_poses) ||
      std::ranges::any_of(sensor_idx, [&](int i) { return i < 0 || i >= num_sensors; })) {
    throw DataError("bundle adjustment: {} calibrations and {} motions do not fit {} poses",
                    num_sensors,
                    problem.motions.size(),
                    num_poses);
  }
}

std::size_t SensorOf(std::size_t pose, const BundleProblem& data) {
  return data.sensor_idx.empty() ? 0 : static_cast<std::size_t>(data.sensor_idx[pose]);
}

PointMotion MotionOf(std::size_t pose, const BundleProblem& data) {
  return data.motions.empty() ? PointMotion{} : data.motions[pose];
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

ceres::LossFunction* MakeLoss(const BundleOptions& options) {
  if (options.loss == RobustLoss::kCauchy) return new ceres::CauchyLoss(options.robust_scale);
  return new ceres::HuberLoss(options.robust_scale);
}

// One block: focal scale, readout, depth scale.
static_assert(sizeof(CameraCalibration) == 3 * sizeof(double));

Eigen::Array3d FreeCalibration(const BundleOptions& options, std::size_t sensor) {
  const double calibrates = options.calibrate ? 1 : 0;
  return {calibrates, calibrates, options.estimate_depth_scales && sensor > 0 ? 1.0 : 0.0};
}

void AddObservations(const BundleOptions& options, BundleProblem* data, ceres::Problem* problem) {
  for (const BundleObservation& observation : data->observations) {
    const auto pose = static_cast<std::size_t>(observation.pose_idx);
    Rigid3& camera_from_world = data->camera_from_world[pose];
    const std::size_t sensor = SensorOf(pose, *data);
    problem->AddResidualBlock(
        new ObservationError(observation,
                             data->cameras[pose],
                             MotionOf(pose, *data),
                             FreeCalibration(options, sensor)),
        MakeLoss(options),
        camera_from_world.rotation.coeffs().data(),
        camera_from_world.translation.data(),
        data->points_in_world[static_cast<std::size_t>(observation.point_idx)].data(),
        &data->calibrations[sensor].focal_scale);
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
  for (CameraCalibration& calibration : data->calibrations) {
    double* block = &calibration.focal_scale;
    if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);
  }
  return ordering;
}

// Held, or pulled to what is configured as strongly as that is believed. An entry that is held
// beside free ones has no derivative, so that its prior, which it obeys already, leaves it in
// place.
void HoldCalibrations(const BundleOptions& options, BundleProblem* data, ceres::Problem* problem) {
  for (std::size_t sensor = 0; sensor < data->calibrations.size(); ++sensor) {
    const CameraCalibration& start = data->calibrations[sensor];
    double* block = &data->calibrations[sensor].focal_scale;
    if (!problem->HasParameterBlock(block)) continue;
    const Eigen::Array3d is_free = FreeCalibration(options, sensor);
    if ((is_free == 0).all()) {
      problem->SetParameterBlockConstant(block);
      continue;
    }
    Eigen::Vector3d weights(1 / options.focal_scale_sigma, 1 / options.readout_sigma_s, 0);
    Eigen::Vector3d believed(1, 0, 1);
    for (int i = 0; i < 3; ++i) {
      if (is_free[i] != 0) continue;
      weights[i] = 1;
      believed[i] = (&start.focal_scale)[i];
    }
    const Eigen::Matrix3d weight_matrix = weights.asDiagonal();
    problem->AddResidualBlock(new ceres::NormalPrior(weight_matrix, believed), nullptr, block);
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
  HoldCalibrations(options, data, &problem);
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

double ReprojectionError_px(const BundleProblem& data, const BundleObservation& observation) {
  const auto pose = static_cast<std::size_t>(observation.pose_idx);
  const std::size_t sensor = SensorOf(pose, data);
  const Rigid3& camera_from_world = data.camera_from_world[pose];
  const std::array<const double*, 4> parameters = {
      camera_from_world.rotation.coeffs().data(),
      camera_from_world.translation.data(),
      data.points_in_world[static_cast<std::size_t>(observation.point_idx)].data(),
      &data.calibrations[sensor].focal_scale};
  Eigen::Vector3d residuals = Eigen::Vector3d::Zero();
  const ObservationError error(observation, data.cameras[pose], MotionOf(pose, data));
  const bool is_seen = error.Evaluate(parameters.data(), residuals.data(), nullptr);
  return is_seen ? observation.pixel_sigma_px * residuals.head<2>().norm()
                 : std::numeric_limits<double>::infinity();
}

}  // namespace nightmap
