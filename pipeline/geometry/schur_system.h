// SPDX-License-Identifier: Apache-2.0
// Damped normal equations of bundle adjustment with the points eliminated, solved by sparse
// Cholesky factorization (Triggs et al., 2000, section 6; the damping of Marquardt, 1963). One
// thread sums each pose's rows in the order of the observations, so the result is the same at any
// number of threads; Ceres's is not. Points are eliminated part by part, so that no more than one
// part's observations are linearized in memory; parts depend on the problem alone.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"
#include "pipeline/geometry/schur_part.h"
#include "pipeline/geometry/schur_pattern.h"
#include "pipeline/geometry/sparse_cholesky.h"

namespace nightmap {

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

class SchurSystem {
 public:
  static constexpr std::size_t kMaxPart = 1 << 20;  // observations that are linearized at a time

  // Takes the fixed structure: which pose sees which point. Keeps a reference. `linearize`: at the
  // current estimate, the same until EstimateMoved. Throws DataError when the system is too large.
  SchurSystem(const BundleProblem& problem,
              bool has_calibrations,
              int num_threads,
              Linearize linearize,
              std::size_t max_part = kMaxPart);

  // To be called when poses, points or calibrations changed.
  void EstimateMoved() { is_linear_ = false; }

  // The step that minimizes the linearized cost plus the damping, which is every variable's own
  // curvature over `trust`, times its step squared. Returns nothing when the system is not positive
  // definite; more damping may help. Throws DataError when its factor does not fit; no damping will
  // help. `priors` holds one per sensor and is ignored when calibrations are held fixed.
  [[nodiscard]] std::optional<BundleStep> Solve(const std::vector<LinearPrior>& priors,
                                                double trust);

  // Standard deviation of a calibration's parameter, three per sensor, while all else is free;
  // infinite when nothing determines it. The observations' residuals must be over their standard
  // deviations.
  [[nodiscard]] double CalibrationSigma(const std::vector<LinearPrior>& priors,
                                        Eigen::Index parameter);

 private:
  struct PoseBlock {
    Matrix6d hessian = Matrix6d::Zero();
    Vector6d damping = Vector6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    Vector6d eliminated = Vector6d::Zero();  // of the gradient, with the points
  };
  struct CalibrationBlock {
    Eigen::MatrixXd hessian;
    Eigen::VectorXd damping;
    Eigen::VectorXd gradient;
    Eigen::MatrixXd eliminated_hessian;  // with the points
    Eigen::VectorXd eliminated;          // of the gradient
  };

  std::size_t PoseOf(int observation) const;
  std::size_t PointOf(int observation) const;
  std::size_t SensorOf(int observation) const;
  Eigen::Index NumCalibrations() const { return has_calibrations_ ? 3 * num_sensors_ : 0; }

  // Makes it the part in memory.
  void Load(const SchurRange& range, double trust);
  std::vector<std::size_t> PosesOf(const SchurRange& range) const;
  std::span<const int> ObservationsOf(std::size_t pose, const SchurRange& range) const;

  // Fills the reduced system.
  void Eliminate(const std::vector<LinearPrior>& priors, double trust);
  void Clear(const std::vector<LinearPrior>& priors);
  void AddPoseRow(const SchurRange& range, std::size_t pose);
  void AddCalibrationRows(const SchurRange& range);
  void FinishPoses(double trust);
  void FinishCalibrations(double trust);
  Eigen::Map<Eigen::MatrixXd> ColumnsOf(std::size_t pose);
  BundleStep StepOf(const Eigen::VectorXd& solution, double trust);
  Eigen::Vector3d PointStep(const BundleStep& step, std::size_t point) const;

  const BundleProblem& problem_;
  bool has_calibrations_;
  int num_threads_;
  Linearize linearize_;
  Eigen::Index num_sensors_;
  IndexGroups of_point_;  // observations of each point
  IndexGroups of_pose_;
  std::vector<SchurRange> ranges_;
  BlockPattern pattern_;
  SchurPart part_;
  bool is_linear_ = false;  // the part in memory, at the estimate
  std::size_t first_in_part_ = 0;

  std::vector<PoseBlock> poses_;
  CalibrationBlock calibrations_;
  Eigen::VectorXd right_side_;
  SparseCholesky cholesky_{
      "use a machine with more memory, or lower max_tracks_per_frame in "
      "configs/sites/<site>/odometry.toml and max_tracks_per_keyframe in "
      "configs/sites/<site>/adjust.toml"};
};

}  // namespace nightmap
