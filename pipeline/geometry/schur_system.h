// SPDX-License-Identifier: Apache-2.0
// Damped normal equations of bundle adjustment with the points eliminated, solved by sparse
// Cholesky factorization (Triggs et al., 2000, section 6; the damping of Marquardt, 1963). One
// thread sums each pose's rows in the order of the observations, so the result is the same at any
// number of threads; Ceres's is not.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"
#include "pipeline/geometry/sparse_cholesky.h"

namespace nightmap {

struct ObservationJacobian {
  Eigen::Matrix<double, 3, 6> by_pose;  // left perturbation of camera_from_world
  Eigen::Matrix3d by_point;
  Eigen::Matrix3d by_calibration;  // focal scale, readout, depth scale or offset
};

// An observation linearized at the current estimate, times the square root of its robust weight.
struct LinearObservation {
  ObservationJacobian jacobian;
  Eigen::Vector3d residual;
};

// Prior of a calibration: 0.5 x^T H x + g^T x of its step x.
struct LinearPrior {
  Eigen::Vector3d hessian_diagonal;
  Eigen::Vector3d gradient;
};

struct BundleStep {
  std::vector<Vector6d> poses;                // left perturbations; zero for a fixed pose
  std::vector<Eigen::Vector3d> points;        // zero for a point without observations
  std::vector<Eigen::Vector3d> calibrations;  // zero when they are held fixed
  double predicted_decrease = 0;              // decrease of half the sum of squares
};

// Indices by group; ascending in each group.
class IndexGroups {
 public:
  IndexGroups() = default;
  IndexGroups(const std::vector<int>& group_of_index, std::size_t num_groups);
  std::span<const int> Of(std::size_t group) const {
    return {members_.data() + begins_[group], members_.data() + begins_[group + 1]};
  }

 private:
  std::vector<std::size_t> begins_;
  std::vector<int> members_;
};

class SchurSystem {
 public:
  // Takes the fixed structure: which pose sees which point. Keeps a reference. Throws DataError
  // when the system is too large.
  SchurSystem(const BundleProblem& problem, bool has_calibrations, int num_threads);

  // The step that minimizes the linearized cost plus the damping, which is every variable's own
  // curvature over `trust`, times its step squared. Returns nothing when the system is not positive
  // definite; more damping may help. Throws DataError when its factor does not fit; no damping will
  // help. `priors` holds one per sensor and is ignored when calibrations are held fixed.
  [[nodiscard]] std::optional<BundleStep> Solve(const std::vector<LinearObservation>& observations,
                                                const std::vector<LinearPrior>& priors,
                                                double trust);

  // Standard deviation of a calibration's parameter, three per sensor, while all else is free;
  // infinite when nothing determines it. The observations' residuals must be over their standard
  // deviations.
  [[nodiscard]] double CalibrationSigma(const std::vector<LinearObservation>& observations,
                                        const std::vector<LinearPrior>& priors,
                                        Eigen::Index parameter);

 private:
  using Matrix63d = Eigen::Matrix<double, 6, 3>;

  // A point at the current estimate: its own block, and its coupling to calibrations.
  struct PointBlock {
    Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();  // of the damped Hessian
    Eigen::Vector3d damping = Eigen::Vector3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  };
  struct PoseBlock {
    Vector6d damping = Vector6d::Zero();
    Vector6d gradient = Vector6d::Zero();
  };
  struct CalibrationBlock {
    Eigen::VectorXd damping;
    Eigen::VectorXd gradient;
  };

  std::size_t PoseOf(int observation) const;
  std::size_t PointOf(int observation) const;
  std::size_t SensorOf(int observation) const;
  std::vector<std::vector<int>> FindNeighbours(int num_threads) const;
  void OrderPoses(const std::vector<std::vector<int>>& neighbours);
  std::size_t NumEntries() const;
  void LayOut(const std::vector<std::vector<int>>& neighbours);
  Eigen::Index NumCalibrations() const { return has_calibrations_ ? 3 * num_sensors_ : 0; }

  void EliminatePoint(const std::vector<LinearObservation>& observations,
                      double trust,
                      std::size_t point);
  void SumPoseRow(const std::vector<LinearObservation>& observations,
                  double trust,
                  std::size_t pose);
  // Fills the reduced system.
  void Eliminate(const std::vector<LinearObservation>& observations,
                 const std::vector<LinearPrior>& priors,
                 double trust);
  void SumCalibrationRows(const std::vector<LinearObservation>& observations,
                          const std::vector<LinearPrior>& priors,
                          double trust);
  Eigen::Vector3d PointStep(const BundleStep& step, std::size_t point) const;
  double PredictedDecrease(const BundleStep& step) const;

  const BundleProblem& problem_;
  bool has_calibrations_;
  int num_threads_;
  Eigen::Index num_sensors_;
  IndexGroups of_point_;  // observations of each point
  IndexGroups of_pose_;
  // Rank of a pose in the order of elimination; -1: fixed or without any point.
  std::vector<int> rank_;
  // By pose: the later-ranked poses with which it shares points.
  std::vector<std::vector<int>> later_;

  std::vector<PointBlock> points_;
  std::vector<Eigen::Matrix3Xd> calibration_by_point_;  // transposed: 3 rows, NumCalibrations()
  std::vector<Matrix63d> pose_by_point_;                // by observation
  std::vector<PoseBlock> poses_;
  CalibrationBlock calibrations_;
  // Lower triangle of the reduced system: the poses by rank, then the calibrations.
  Eigen::SparseMatrix<double> reduced_;
  Eigen::VectorXd right_side_;
  SparseCholesky cholesky_;
};

}  // namespace nightmap
