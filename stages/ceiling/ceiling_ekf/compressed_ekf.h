// SPDX-License-Identifier: Apache-2.0
// An extended Kalman filter whose time per step does not grow with what it keeps: the compressed
// filter of Guivant and Nebot, Optimization of the simultaneous localization and map-building
// algorithm for real-time implementation, IEEE Trans. Robotics and Automation 17(3), 2001.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace nightmap {

// A measurement of the state: residual = measured - predicted, with independent noise. `active` is
// the derivative of the prediction by the active states, one row per residual.
struct Measurement {
  Eigen::SparseMatrix<double, Eigen::RowMajor> active;
  Eigen::VectorXd residual;
  Eigen::VectorXd variance;  // > 0
};

// How well a measurement agreed with the prediction: normalized innovation squared, which has the
// chi-square distribution of as many degrees of freedom if all is modelled.
struct Innovation {
  double squared = 0;
  int degrees_of_freedom = 0;
};

// Mean and covariance of a state in two parts: the active one, which changes and is measured, and
// the kept one, which stands still and changes only by its correlation with the active one. Effects
// of the active part's steps on the kept part are gathered (Phi, Psi, theta of the paper) and
// applied when somebody asks for it, so a step costs O(n^2 m) for n active states and m residuals
// however much is kept. Applying them costs O(k^2 rank) for k kept states, whose covariance is
// one triangle of k^2 numbers that is changed in place. Beyond the paper, the covariance of both
// parts is factored first: it has a small rank, because what is near knows little of what is far,
// and a step costs O(n m rank) for it. The result is that of the plain filter, to 1e-10 of that
// covariance. In the linear-Gaussian case it is the Kalman filter. Copies share what is kept.
// Deterministic; one thread.
class CompressedEkf {
 public:
  // Nothing is kept. Active state `considered`, if not negative, is one that no measurement can
  // tell (Schmidt, Application of state-space methods to navigation problems, 1966): its mean and
  // variance change by Transform only, and what it does to the others stays in their covariance.
  // Then this is no Kalman filter any more, but one that knows less. Its index stays: Transform,
  // Select and Keep must leave it and the states before it where they are.
  CompressedEkf(Eigen::VectorXd mean, Eigen::MatrixXd covariance, Eigen::Index considered = -1);

  Eigen::Index NumActive() const { return active_.size(); }
  Eigen::Index NumKept() const { return kept_->mean.size(); }
  const Eigen::VectorXd& Active() const { return active_; }
  const Eigen::MatrixXd& ActiveCovariance() const { return covariance_; }

  // The new active state is f(old) with the derivative `jacobian`; `noise` is the covariance that
  // is added (its size that of the new state). Prediction, a state that is copied, appended or
  // removed, and another frame of reference are all of this kind.
  void Transform(Eigen::VectorXd mean,
                 const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian,
                 const Eigen::SparseMatrix<double, Eigen::RowMajor>& noise);
  // The same for states that are only taken away: those of `rest` stay, in this order.
  void Select(const std::vector<Eigen::Index>& rest);

  // The innovation squared that Update would have by each `size` residuals in a row, alone; changes
  // nothing.
  std::vector<double> Test(const Measurement& measurement, Eigen::Index size) const;
  // Joint update by all residuals. Throws DataError when the covariance of the innovation is not
  // positive definite, or anything is not finite.
  Innovation Update(const Measurement& measurement);
  // Updates by a measurement that involves the kept states too: `kept` is the derivative by them.
  Innovation Update(const Measurement& measurement,
                    const Eigen::SparseMatrix<double, Eigen::RowMajor>& kept);

  // Moves active states first .. first + count - 1 to the end of the kept ones.
  void Keep(Eigen::Index first, Eigen::Index count);

  // These have all steps so far in them.
  const Eigen::VectorXd& Kept();
  Eigen::MatrixXd KeptCovariance(Eigen::Index first, Eigen::Index count);  // of these
  // Rows: active states, columns: kept states.
  const Eigen::MatrixXd& CrossCovariance();

 private:
  struct KeptPart {
    // One state more makes no copy of the covariance: there is room for some.
    void Grow(Eigen::Index count);
    // The covariance; only the triangle below the diagonal, and with it, is valid.
    Eigen::Block<Eigen::MatrixXd> Lower() {
      return triangle.topLeftCorner(mean.size(), mean.size());
    }

    Eigen::VectorXd mean;
    Eigen::MatrixXd triangle;
    // Active x kept; when steps are deferred, the factor of it that stays: rank x kept.
    Eigen::MatrixXd cross;
  };
  // Terms of one update. With S = L L^T, the covariance of the innovation: L^-1 H P and L^-1 r,
  // so that the correction is root^T residual, and the covariance loses root^T root.
  struct Gain {
    Eigen::MatrixXd factor;  // L
    Eigen::MatrixXd root;
    Eigen::VectorXd residual;
  };
  Gain Solve(const Measurement& measurement) const;
  // Moves the active states by root^T residual, and takes root^T root from their covariance.
  Innovation Correct(const Gain& gain);
  // The kept part, to be changed: copied first if another filter shares it.
  KeptPart& Own();
  bool IsDeferred() const { return phi_.size() > 0; }
  // Begins to gather, where that pays.
  void Defer();
  void Flush();

  Eigen::Index considered_;
  Eigen::VectorXd active_;
  Eigen::MatrixXd covariance_;
  std::shared_ptr<KeptPart> kept_;  // as of the last Flush, if steps are deferred
  // Gathered since then: the covariance of active and kept states is phi_ * cross. Empty when steps
  // are not deferred.
  Eigen::MatrixXd phi_;
  Eigen::MatrixXd psi_;
  Eigen::VectorXd theta_;
};

}  // namespace nightmap
