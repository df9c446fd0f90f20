// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/schur_system.h"

#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

constexpr double kMinCurvature = 1e-6;  // keeps the system regular where nothing is measured

template <typename Vector>
Vector Damping(const Vector& hessian_diagonal, double trust) {
  return hessian_diagonal.cwiseMax(kMinCurvature) / trust;
}

}  // namespace

IndexGroups::IndexGroups(const std::vector<int>& group_of_index, std::size_t num_groups)
    : begins_(num_groups + 1, 0), members_(group_of_index.size()) {
  for (const int group : group_of_index) ++begins_[static_cast<std::size_t>(group) + 1];
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  std::vector<std::size_t> next = begins_;
  for (std::size_t i = 0; i < group_of_index.size(); ++i) {
    members_[next[static_cast<std::size_t>(group_of_index[i])]++] = static_cast<int>(i);
  }
}

SchurSystem::SchurSystem(const BundleProblem& problem, bool has_calibrations, int num_threads)
    : problem_(problem),
      has_calibrations_(has_calibrations),
      num_threads_(num_threads),
      num_sensors_(static_cast<Eigen::Index>(problem.calibrations.size())),
      rank_(problem.camera_from_world.size(), -1),
      later_(problem.camera_from_world.size()),
      points_(problem.points_in_world.size()),
      calibration_by_point_(problem.points_in_world.size()),
      pose_by_point_(problem.observations.size()),
      poses_(problem.camera_from_world.size()) {
  std::vector<int> point_of_observation;
  std::vector<int> pose_of_observation;
  for (const BundleObservation& o : problem.observations) {
    point_of_observation.push_back(o.point_idx);
    pose_of_observation.push_back(o.pose_idx);
  }
  of_point_ = IndexGroups(point_of_observation, points_.size());
  of_pose_ = IndexGroups(pose_of_observation, poses_.size());
  const auto neighbours = FindNeighbours(num_threads);
  OrderPoses(neighbours);
  LayOut(neighbours);
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
  const auto& sensor_idx = problem_.sensor_idx;
  return sensor_idx.empty() ? 0 : static_cast<std::size_t>(sensor_idx[PoseOf(observation)]);
}

// For each pose the others that see one of its points, ascending. Only poses that may move.
std::vector<std::vector<int>> SchurSystem::FindNeighbours(int num_threads) const {
  std::vector<std::vector<int>> neighbours(poses_.size());
  ParallelFor(poses_.size(), num_threads, [&](std::size_t pose) {
    if (problem_.is_fixed[pose]) return;
    std::vector<bool> is_seen(poses_.size(), false);
    is_seen[pose] = true;
    for (const int o : of_pose_.Of(pose)) {
      for (const int other : of_point_.Of(PointOf(o))) {
        const std::size_t other_pose = PoseOf(other);
        if (is_seen[other_pose] || problem_.is_fixed[other_pose]) continue;
        is_seen[other_pose] = true;
        neighbours[pose].push_back(static_cast<int>(other_pose));
      }
    }
  });
  return neighbours;
}

// Approximate minimum degree on poses, because the pattern inside a block does not help.
void SchurSystem::OrderPoses(const std::vector<std::vector<int>>& neighbours) {
  std::vector<int> free;
  std::vector<int> position(poses_.size(), -1);
  for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
    if (problem_.is_fixed[pose] || of_pose_.Of(pose).empty()) continue;
    position[pose] = static_cast<int>(free.size());
    free.push_back(static_cast<int>(pose));
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (const int pose : free) {
    const auto i = static_cast<std::size_t>(pose);
    entries.emplace_back(position[i], position[i], 1);
    for (const int other : neighbours[i]) {
      entries.emplace_back(position[i], position[static_cast<std::size_t>(other)], 1);
    }
  }
  const auto num_free = static_cast<Eigen::Index>(free.size());
  Eigen::SparseMatrix<double> pattern(num_free, num_free);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  for (Eigen::Index k = 0; k < num_free; ++k) {
    const auto pose = static_cast<std::size_t>(free[static_cast<std::size_t>(order.indices()[k])]);
    rank_[pose] = static_cast<int>(k);
  }
}

// Counts the entries of the lower triangle that LayOut makes. `later_` must be known.
std::size_t SchurSystem::NumEntries() const {
  const auto num_calibrations = static_cast<std::size_t>(NumCalibrations());
  std::size_t count = num_calibrations * num_calibrations;
  for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
    if (rank_[pose] >= 0) count += 6 * (6 * (later_[pose].size() + 1) + num_calibrations);
  }
  return count;
}

// Lays out the pattern of the lower triangle. Blocks on the diagonal are stored whole.
void SchurSystem::LayOut(const std::vector<std::vector<int>>& neighbours) {
  std::vector<std::size_t> pose_at;
  for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
    if (rank_[pose] < 0) continue;
    pose_at.push_back(pose);
    for (const int other : neighbours[pose]) {
      if (rank_[static_cast<std::size_t>(other)] > rank_[pose]) later_[pose].push_back(other);
    }
    std::ranges::sort(later_[pose], {}, [&](int i) { return rank_[static_cast<std::size_t>(i)]; });
  }
  std::ranges::sort(pose_at, {}, [&](std::size_t pose) { return rank_[pose]; });
  const auto num_pose_columns = static_cast<int>(6 * pose_at.size());
  const int size = num_pose_columns + static_cast<int>(NumCalibrations());
  const int num_entries = SparseIndex(NumEntries());
  std::vector<int> begins = {0};
  std::vector<int> rows;
  rows.reserve(static_cast<std::size_t>(num_entries));
  const auto add_column = [&](std::span<const int> block_rows) {
    rows.insert(rows.end(), block_rows.begin(), block_rows.end());
    begins.push_back(static_cast<int>(rows.size()));
  };
  std::vector<int> calibration_rows(static_cast<std::size_t>(NumCalibrations()));
  std::iota(calibration_rows.begin(), calibration_rows.end(), num_pose_columns);
  for (const std::size_t pose : pose_at) {
    std::vector<int> block_rows;
    const auto add_rows = [&](int rank) {
      for (int i = 0; i < 6; ++i) block_rows.push_back(6 * rank + i);
    };
    add_rows(rank_[pose]);
    for (const int other : later_[pose]) add_rows(rank_[static_cast<std::size_t>(other)]);
    block_rows.insert(block_rows.end(), calibration_rows.begin(), calibration_rows.end());
    for (int i = 0; i < 6; ++i) add_column(block_rows);
  }
  for (std::size_t i = 0; i < calibration_rows.size(); ++i) add_column(calibration_rows);
  const std::vector<double> zeros(rows.size(), 0);
  reduced_ = Eigen::Map<const Eigen::SparseMatrix<double>>(
      size, size, num_entries, begins.data(), rows.data(), zeros.data());
  right_side_.resize(size);
  if (size > 0) cholesky_.Analyze(reduced_);
}

void SchurSystem::EliminatePoint(const std::vector<LinearObservation>& observations,
                                 double trust,
                                 std::size_t point) {
  PointBlock& block = points_[point];
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Matrix3Xd& by_calibration = calibration_by_point_[point];
  by_calibration.setZero(3, NumCalibrations());
  block.gradient.setZero();
  for (const int o : of_point_.Of(point)) {
    const auto& [jacobian, residual] = observations[static_cast<std::size_t>(o)];
    hessian += jacobian.by_point.transpose() * jacobian.by_point;
    block.gradient += jacobian.by_point.transpose() * residual;
    pose_by_point_[static_cast<std::size_t>(o)] = jacobian.by_pose.transpose() * jacobian.by_point;
    if (!has_calibrations_) continue;
    by_calibration.middleCols<3>(static_cast<Eigen::Index>(3 * SensorOf(o))) +=
        jacobian.by_point.transpose() * jacobian.by_calibration;
  }
  block.damping = Damping<Eigen::Vector3d>(hessian.diagonal(), trust);
  hessian.diagonal() += block.damping;
  block.inverse = hessian.inverse();
}

// The rows of one pose from the diagonal on, as columns of the lower triangle.
void SchurSystem::SumPoseRow(const std::vector<LinearObservation>& observations,
                             double trust,
                             std::size_t pose) {
  if (rank_[pose] < 0) return;
  const Eigen::Index first_column = 6 * rank_[pose];
  std::vector<int> slot(poses_.size(), -1);
  slot[pose] = 0;
  for (std::size_t i = 0; i < later_[pose].size(); ++i) {
    slot[static_cast<std::size_t>(later_[pose][i])] = static_cast<int>(i) + 1;
  }
  const Eigen::Index calibration_slot = 6 * static_cast<Eigen::Index>(later_[pose].size() + 1);
  Eigen::Matrix<double, 6, Eigen::Dynamic> row;
  row.setZero(6, calibration_slot + NumCalibrations());
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  Vector6d eliminated = Vector6d::Zero();
  for (const int o : of_pose_.Of(pose)) {
    const auto& [jacobian, residual] = observations[static_cast<std::size_t>(o)];
    const std::size_t point = PointOf(o);
    hessian += jacobian.by_pose.transpose() * jacobian.by_pose;
    gradient += jacobian.by_pose.transpose() * residual;
    const Matrix63d gain = pose_by_point_[static_cast<std::size_t>(o)] * points_[point].inverse;
    eliminated += gain * points_[point].gradient;
    for (const int other : of_point_.Of(point)) {
      const int other_slot = slot[PoseOf(other)];
      if (other_slot < 0) continue;
      row.middleCols<6>(6 * other_slot).noalias() -=
          gain.lazyProduct(pose_by_point_[static_cast<std::size_t>(other)].transpose());
    }
    if (!has_calibrations_) continue;
    row.middleCols<3>(calibration_slot + static_cast<Eigen::Index>(3 * SensorOf(o))) +=
        jacobian.by_pose.transpose() * jacobian.by_calibration;
    row.rightCols(NumCalibrations()) -= gain * calibration_by_point_[point];
  }
  poses_[pose] = {Damping<Vector6d>(hessian.diagonal(), trust), gradient};
  hessian.diagonal() += poses_[pose].damping;
  row.leftCols<6>() += hessian;
  right_side_.segment<6>(first_column) = eliminated - gradient;
  Eigen::Map<Eigen::MatrixXd>(
      reduced_.valuePtr() + reduced_.outerIndexPtr()[first_column], row.cols(), 6) =
      row.transpose();
}

void SchurSystem::SumCalibrationRows(const std::vector<LinearObservation>& observations,
                                     const std::vector<LinearPrior>& priors,
                                     double trust) {
  const Eigen::Index size = NumCalibrations();
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd gradient(size);
  for (Eigen::Index sensor = 0; sensor < num_sensors_; ++sensor) {
    const auto& [diagonal, of_prior] = priors[static_cast<std::size_t>(sensor)];
    hessian.diagonal().segment<3>(3 * sensor) = diagonal;
    gradient.segment<3>(3 * sensor) = of_prior;
  }
  for (std::size_t o = 0; o < observations.size(); ++o) {
    const auto& [jacobian, residual] = observations[o];
    const auto first = static_cast<Eigen::Index>(3 * SensorOf(static_cast<int>(o)));
    hessian.block<3, 3>(first, first) +=
        jacobian.by_calibration.transpose() * jacobian.by_calibration;
    gradient.segment<3>(first) += jacobian.by_calibration.transpose() * residual;
  }
  calibrations_ = {Damping<Eigen::VectorXd>(hessian.diagonal(), trust), gradient};
  hessian.diagonal() += calibrations_.damping;
  Eigen::VectorXd right_side = -gradient;
  for (std::size_t point = 0; point < points_.size(); ++point) {
    const Eigen::MatrixX3d gain = calibration_by_point_[point].transpose() * points_[point].inverse;
    hessian -= gain * calibration_by_point_[point];
    right_side += gain * points_[point].gradient;
  }
  right_side_.tail(size) = right_side;
  Eigen::Map<Eigen::MatrixXd>(reduced_.valuePtr() + reduced_.nonZeros() - size * size, size, size) =
      hessian;
}

Eigen::Vector3d SchurSystem::PointStep(const BundleStep& step, std::size_t point) const {
  Eigen::Vector3d gradient = points_[point].gradient;
  for (const int o : of_point_.Of(point)) {
    gradient += pose_by_point_[static_cast<std::size_t>(o)].transpose() * step.poses[PoseOf(o)];
  }
  for (Eigen::Index sensor = 0; 3 * sensor < NumCalibrations(); ++sensor) {
    gradient += calibration_by_point_[point].middleCols<3>(3 * sensor) *
                step.calibrations[static_cast<std::size_t>(sensor)];
  }
  return -points_[point].inverse * gradient;
}

// (H + D) x = -g, so that -g^T x - 0.5 x^T H x = 0.5 (x^T D x - g^T x).
double SchurSystem::PredictedDecrease(const BundleStep& step) const {
  double sum = 0;
  const auto add = [&](const auto& x, const auto& damping, const auto& gradient) {
    sum += 0.5 * (x.cwiseProduct(damping) - gradient).dot(x);
  };
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    if (rank_[i] >= 0) add(step.poses[i], poses_[i].damping, poses_[i].gradient);
  }
  for (std::size_t k = 0; k < points_.size(); ++k) {
    add(step.points[k], points_[k].damping, points_[k].gradient);
  }
  for (Eigen::Index i = 0; 3 * i < NumCalibrations(); ++i) {
    add(step.calibrations[static_cast<std::size_t>(i)],
        calibrations_.damping.segment<3>(3 * i),
        calibrations_.gradient.segment<3>(3 * i));
  }
  return sum;
}

void SchurSystem::Eliminate(const std::vector<LinearObservation>& observations,
                            const std::vector<LinearPrior>& priors,
                            double trust) {
  ParallelFor(points_.size(), num_threads_, [&](std::size_t point) {
    EliminatePoint(observations, trust, point);
  });
  ParallelFor(poses_.size(), num_threads_, [&](std::size_t pose) {
    SumPoseRow(observations, trust, pose);
  });
  if (has_calibrations_) SumCalibrationRows(observations, priors, trust);
}

double SchurSystem::CalibrationSigma(const std::vector<LinearObservation>& observations,
                                     const std::vector<LinearPrior>& priors,
                                     Eigen::Index parameter) {
  constexpr double kUndamped = 1e12;
  Eliminate(observations, priors, kUndamped);
  const Eigen::Index size = right_side_.size();
  const Eigen::Index row = size - NumCalibrations() + parameter;
  const auto column = cholesky_.Solve(reduced_, Eigen::VectorXd::Unit(size, row));
  if (!column || !((*column)[row] > 0)) return std::numeric_limits<double>::infinity();
  return std::sqrt((*column)[row]);
}

std::optional<BundleStep> SchurSystem::Solve(const std::vector<LinearObservation>& observations,
                                             const std::vector<LinearPrior>& priors,
                                             double trust) {
  Eliminate(observations, priors, trust);
  Eigen::VectorXd solution;
  if (right_side_.size() > 0) {
    auto solved = cholesky_.Solve(reduced_, right_side_);
    if (!solved || !solved->allFinite()) return {};
    solution = *std::move(solved);
  }
  BundleStep step;
  for (const int rank : rank_) {
    step.poses.push_back(rank < 0 ? Vector6d::Zero() : Vector6d(solution.segment<6>(6 * rank)));
  }
  for (Eigen::Index sensor = 0; sensor < num_sensors_; ++sensor) {
    const Eigen::Index first = solution.size() - NumCalibrations() + 3 * sensor;
    step.calibrations.push_back(has_calibrations_ ? Eigen::Vector3d(solution.segment<3>(first))
                                                  : Eigen::Vector3d::Zero());
  }
  step.points.resize(points_.size());
  ParallelFor(points_.size(), num_threads_, [&](std::size_t point) {
    step.points[point] = PointStep(step, point);
  });
  step.predicted_decrease = PredictedDecrease(step);
  return step;
}

}  // namespace nightmap
