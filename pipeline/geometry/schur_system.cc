// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/schur_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/row_slots.h"

namespace nightmap {
namespace {

IndexGroups ByMember(const BundleProblem& problem,
                     int BundleObservation::*member,
                     std::size_t num_groups) {
  std::vector<int> groups;
  groups.reserve(problem.observations.size());
  for (const BundleObservation& o : problem.observations) groups.push_back(o.*member);
  return {groups, num_groups};
}

}  // namespace

SchurSystem::SchurSystem(const BundleProblem& problem,
                         bool has_calibrations,
                         int num_threads,
                         Linearize linearize,
                         std::size_t max_part)
    : problem_(problem),
      has_calibrations_(has_calibrations),
      num_threads_(num_threads),
      linearize_(std::move(linearize)),
      num_sensors_(static_cast<Eigen::Index>(problem.calibrations.size())),
      of_point_(ByMember(problem, &BundleObservation::point_idx, problem.points_in_world.size())),
      of_pose_(ByMember(problem, &BundleObservation::pose_idx, problem.camera_from_world.size())),
      ranges_(CutIntoRanges(problem, max_part)),
      pattern_(MakeSchurPattern(
          problem, of_pose_, of_point_, static_cast<int>(NumCalibrations()), num_threads)),
      part_(problem, of_point_, has_calibrations),
      poses_(problem.camera_from_world.size()),
      right_side_(pattern_.lower.rows()) {
  if (right_side_.size() > 0) cholesky_.Analyze(pattern_.lower);
}

std::size_t SchurSystem::PoseOf(int observation) const {
  return static_cast<std::size_t>(
      problem_.observations[static_cast<std::size_t>(observation)].pose_idx);
}

std::size_t SchurSystem::PointOf(int observation) const {
  return static_cast<std::size_t>(
      problem_.observations[static_cast<std::size_t>(observation)].point_idx);
}

std::size_t SchurSystem::SensorOf(int observation) const {
  return problem_.SensorOf(problem_.observations[static_cast<std::size_t>(observation)]);
}

void SchurSystem::Load(const SchurRange& range, double trust) {
  if (!is_linear_ || first_in_part_ != range.begin) {
    part_.LinearizeRange(range, linearize_, num_threads_);
  }
  is_linear_ = true;
  first_in_part_ = range.begin;
  part_.EliminatePoints(trust, num_threads_);
}

// Poses with observations in the range, ascending.
std::vector<std::size_t> SchurSystem::PosesOf(const SchurRange& range) const {
  std::vector<bool> is_seen(poses_.size(), false);
  for (std::size_t o = range.begin; o < range.end; ++o) {
    is_seen[static_cast<std::size_t>(problem_.observations[o].pose_idx)] = true;
  }
  std::vector<std::size_t> poses;
  for (std::size_t pose = 0; pose < is_seen.size(); ++pose) {
    if (is_seen[pose] && pattern_.rank[pose] >= 0) poses.push_back(pose);
  }
  return poses;
}

std::span<const int> SchurSystem::ObservationsOf(std::size_t pose, const SchurRange& range) const {
  const std::span<const int> all = of_pose_.Of(pose);
  const auto begin = std::ranges::lower_bound(all, static_cast<int>(range.begin));
  const auto end = std::lower_bound(begin, all.end(), static_cast<int>(range.end));
  return {begin, end};
}

// The columns of the lower triangle: its rows from the diagonal on, transposed.
Eigen::Map<Eigen::MatrixXd> SchurSystem::ColumnsOf(std::size_t pose) {
  Eigen::SparseMatrix<double>& reduced = pattern_.lower;
  const Eigen::Index num_rows =
      6 * static_cast<Eigen::Index>(pattern_.later[pose].size() + 1) + NumCalibrations();
  return {reduced.valuePtr() + reduced.outerIndexPtr()[6 * pattern_.rank[pose]], num_rows, 6};
}

void SchurSystem::AddPoseRow(const SchurRange& range, std::size_t pose) {
  const std::vector<int>& later = pattern_.later[pose];
  const RowSlots slots(poses_.size(), pose, later);
  const Eigen::Index calibration_slot = 6 * static_cast<Eigen::Index>(later.size() + 1);
  Eigen::Matrix<double, 6, Eigen::Dynamic> row;
  row.setZero(6, calibration_slot + NumCalibrations());
  PoseBlock& block = poses_[pose];
  for (const int o : ObservationsOf(pose, range)) {
    const auto& [jacobian, residual] = part_.Linear(o);
    const SchurPart::Point& point = part_.At(PointOf(o));
    block.hessian += jacobian.by_pose.transpose() * jacobian.by_pose;
    block.gradient += jacobian.by_pose.transpose() * residual;
    const SchurPart::Matrix63d gain = part_.PoseByPoint(o) * point.inverse;
    block.eliminated += gain * point.gradient;
    for (const int other : of_point_.Of(PointOf(o))) {
      const int other_slot = slots.Of(PoseOf(other));
      if (other_slot < 0) continue;
      row.middleCols<6>(6 * other_slot).noalias() -=
          gain.lazyProduct(part_.PoseByPoint(other).transpose());
    }
    if (!has_calibrations_) continue;
    row.middleCols<3>(calibration_slot + static_cast<Eigen::Index>(3 * SensorOf(o))) +=
        jacobian.by_pose.transpose() * jacobian.by_calibration;
    row.rightCols(NumCalibrations()) -= gain * point.by_calibration;
  }
  ColumnsOf(pose) += row.transpose();
}

void SchurSystem::AddCalibrationRows(const SchurRange& range) {
  for (std::size_t o = range.begin; o < range.end; ++o) {
    const auto& [jacobian, residual] = part_.Linear(static_cast<int>(o));
    const auto first = static_cast<Eigen::Index>(3 * SensorOf(static_cast<int>(o)));
    calibrations_.hessian.block<3, 3>(first, first) +=
        jacobian.by_calibration.transpose() * jacobian.by_calibration;
    calibrations_.gradient.segment<3>(first) += jacobian.by_calibration.transpose() * residual;
  }
  for (std::size_t i = range.first_point; i < range.end_point; ++i) {
    const SchurPart::Point& point = part_.At(i);
    const Eigen::MatrixX3d gain = point.by_calibration.transpose() * point.inverse;
    calibrations_.eliminated_hessian += gain * point.by_calibration;
    calibrations_.eliminated += gain * point.gradient;
  }
}

void SchurSystem::Clear(const std::vector<LinearPrior>& priors) {
  std::fill_n(pattern_.lower.valuePtr(), pattern_.lower.nonZeros(), 0.0);
  std::ranges::fill(poses_, PoseBlock());
  const Eigen::Index size = NumCalibrations();
  calibrations_ = {Eigen::MatrixXd::Zero(size, size),
                   Eigen::VectorXd::Zero(size),
                   Eigen::VectorXd::Zero(size),
                   Eigen::MatrixXd::Zero(size, size),
                   Eigen::VectorXd::Zero(size)};
  for (Eigen::Index sensor = 0; 3 * sensor < size; ++sensor) {
    const auto& [diagonal, of_prior] = priors[static_cast<std::size_t>(sensor)];
    calibrations_.hessian.diagonal().segment<3>(3 * sensor) = diagonal;
    calibrations_.gradient.segment<3>(3 * sensor) = of_prior;
  }
}

void SchurSystem::FinishPoses(double trust) {
  for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
    if (pattern_.rank[pose] < 0) continue;
    PoseBlock& block = poses_[pose];
    block.damping = SchurDamping<Vector6d>(block.hessian.diagonal(), trust);
    block.hessian.diagonal() += block.damping;
    ColumnsOf(pose).topRows<6>() += block.hessian;
    right_side_.segment<6>(6 * pattern_.rank[pose]) = block.eliminated - block.gradient;
  }
}

void SchurSystem::FinishCalibrations(double trust) {
  const Eigen::Index size = NumCalibrations();
  Eigen::SparseMatrix<double>& reduced = pattern_.lower;
  calibrations_.damping = SchurDamping<Eigen::VectorXd>(calibrations_.hessian.diagonal(), trust);
  calibrations_.hessian.diagonal() += calibrations_.damping;
  right_side_.tail(size) = calibrations_.eliminated - calibrations_.gradient;
  Eigen::Map<Eigen::MatrixXd>(reduced.valuePtr() + reduced.nonZeros() - size * size, size, size) =
      calibrations_.hessian - calibrations_.eliminated_hessian;
}

void SchurSystem::Eliminate(const std::vector<LinearPrior>& priors, double trust) {
  Clear(priors);
  for (const SchurRange& range : ranges_) {
    Load(range, trust);
    const std::vector<std::size_t> poses = PosesOf(range);
    ParallelFor(poses.size(), num_threads_, [&](std::size_t i) { AddPoseRow(range, poses[i]); });
    if (has_calibrations_) AddCalibrationRows(range);
  }
  FinishPoses(trust);
  if (has_calibrations_) FinishCalibrations(trust);
}

double SchurSystem::CalibrationSigma(const std::vector<LinearPrior>& priors,
                                     Eigen::Index parameter) {
  constexpr double kUndamped = 1e12;
  Eliminate(priors, kUndamped);
  const Eigen::Index size = right_side_.size();
  const Eigen::Index row = size - NumCalibrations() + parameter;
  const auto column = cholesky_.Solve(pattern_.lower, Eigen::VectorXd::Unit(size, row));
  if (!column || !((*column)[row] > 0)) return std::numeric_limits<double>::infinity();
  return std::sqrt((*column)[row]);
}

std::optional<BundleStep> SchurSystem::Solve(const std::vector<LinearPrior>& priors, double trust) {
  Eliminate(priors, trust);
  Eigen::VectorXd solution;
  if (right_side_.size() > 0) {
    auto solved = cholesky_.Solve(pattern_.lower, right_side_);
    if (!solved || !solved->allFinite()) return {};
    solution = *std::move(solved);
  }
  return StepOf(solution, trust);
}

// (H + D) x = -g, so that -g^T x - 0.5 x^T H x = 0.5 (x^T D x - g^T x).
BundleStep SchurSystem::StepOf(const Eigen::VectorXd& solution, double trust) {
  BundleStep step;
  const auto predict = [&](const auto& x, const auto& damping, const auto& gradient) {
    step.predicted_decrease += 0.5 * (x.cwiseProduct(damping) - gradient).dot(x);
  };
  step.poses.assign(poses_.size(), Vector6d::Zero());
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    if (pattern_.rank[i] < 0) continue;
    step.poses[i] = solution.segment<6>(6 * pattern_.rank[i]);
    predict(step.poses[i], poses_[i].damping, poses_[i].gradient);
  }
  step.calibrations.assign(static_cast<std::size_t>(num_sensors_), Eigen::Vector3d::Zero());
  for (Eigen::Index i = 0; 3 * i < NumCalibrations(); ++i) {
    step.calibrations[static_cast<std::size_t>(i)] =
        solution.segment<3>(solution.size() - NumCalibrations() + 3 * i);
  }
  step.points.resize(problem_.points_in_world.size());
  for (const SchurRange& range : ranges_) {
    Load(range, trust);
    ParallelFor(range.end_point - range.first_point, num_threads_, [&](std::size_t i) {
      step.points[range.first_point + i] = PointStep(step, range.first_point + i);
    });
    for (std::size_t k = range.first_point; k < range.end_point; ++k) {
      predict(step.points[k], part_.At(k).damping, part_.At(k).gradient);
    }
  }
  for (Eigen::Index i = 0; 3 * i < NumCalibrations(); ++i) {
    predict(step.calibrations[static_cast<std::size_t>(i)],
            calibrations_.damping.segment<3>(3 * i),
            calibrations_.gradient.segment<3>(3 * i));
  }
  return step;
}

Eigen::Vector3d SchurSystem::PointStep(const BundleStep& step, std::size_t point) const {
  const SchurPart::Point& block = part_.At(point);
  Eigen::Vector3d gradient = block.gradient;
  for (const int o : of_point_.Of(point)) {
    gradient += part_.PoseByPoint(o).transpose() * step.poses[PoseOf(o)];
  }
  for (Eigen::Index sensor = 0; 3 * sensor < NumCalibrations(); ++sensor) {
    gradient += block.by_calibration.middleCols<3>(3 * sensor) *
                step.calibrations[static_cast<std::size_t>(sensor)];
  }
  return -block.inverse * gradient;
}

}  // namespace nightmap
