// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/compressed_ekf.h"

#include <Eigen/Cholesky>
#include <utility>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

void SubtractSquare(const Eigen::MatrixXd& root, Eigen::MatrixXd* covariance) {
  covariance->selfadjointView<Eigen::Lower>().rankUpdate(root.transpose(), -1);
  covariance->triangularView<Eigen::StrictlyUpper>() = covariance->transpose();
}

Eigen::LLT<Eigen::MatrixXd> Factor(const Eigen::MatrixXd& innovation_covariance) {
  Eigen::LLT<Eigen::MatrixXd> factor(innovation_covariance);
  if (factor.info() == Eigen::Success && innovation_covariance.allFinite()) return factor;
  throw DataError("the covariance of a measurement is not positive definite");
}

}  // namespace

// With S = L L^T, the covariance of the innovation: `root` = L^-1 H P and `residual` = L^-1 r, so
// that the correction is root^T residual and the covariance loses root^T root.
struct CompressedEkf::Gain {
  Eigen::LLT<Eigen::MatrixXd> factor;
  Eigen::MatrixXd root;
  Eigen::VectorXd residual;

  Innovation Result() const { return {residual.squaredNorm(), static_cast<int>(residual.size())}; }
};

CompressedEkf::CompressedEkf(Eigen::VectorXd mean,
                             Eigen::MatrixXd covariance,
                             Eigen::Index considered)
    : considered_(considered),
      active_(std::move(mean)),
      covariance_(std::move(covariance)),
      kept_covariance_(0, 0),
      cross_(active_.size(), 0) {}

void CompressedEkf::Transform(Eigen::VectorXd mean,
                              const SparseRows& jacobian,
                              const SparseRows& noise) {
  active_ = std::move(mean);
  const Eigen::MatrixXd half = jacobian * covariance_;
  covariance_.noalias() = (jacobian * half.transpose()).transpose();
  covariance_ += noise;
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  if (NumKept() > 0)
    phi_ = (jacobian * phi_).eval();
  else
    cross_.resize(active_.size(), 0);
}

void CompressedEkf::Correct(const Eigen::MatrixXd& root, const Eigen::VectorXd& residual) {
  const double mean = considered_ < 0 ? 0 : active_[considered_];
  const double variance = considered_ < 0 ? 0 : covariance_(considered_, considered_);
  active_.noalias() += root.transpose() * residual;
  SubtractSquare(root, &covariance_);
  if (considered_ < 0) return;
  active_[considered_] = mean;
  covariance_(considered_, considered_) = variance;
}

CompressedEkf::Gain CompressedEkf::Solve(const Measurement& measurement) const {
  Gain gain;
  gain.root = measurement.active * covariance_;
  Eigen::MatrixXd innovation = (measurement.active * gain.root.transpose());
  innovation.diagonal() += measurement.variance;
  gain.factor = Factor(innovation);
  gain.factor.matrixL().solveInPlace(gain.root);
  gain.residual = gain.factor.matrixL().solve(measurement.residual);
  return gain;
}

Innovation CompressedEkf::Test(const Measurement& measurement) const {
  Eigen::MatrixXd innovation = measurement.active * (measurement.active * covariance_).transpose();
  innovation.diagonal() += measurement.variance;
  const Eigen::VectorXd residual = Factor(innovation).matrixL().solve(measurement.residual);
  return {residual.squaredNorm(), static_cast<int>(residual.size())};
}

Innovation CompressedEkf::Update(const Measurement& measurement) {
  const Gain gain = Solve(measurement);
  Correct(gain.root, gain.residual);
  if (NumKept() > 0) {
    Eigen::MatrixXd seen = measurement.active * phi_;
    gain.factor.matrixL().solveInPlace(seen);
    phi_.noalias() -= gain.root.transpose() * seen;
    psi_.selfadjointView<Eigen::Lower>().rankUpdate(seen.transpose());
    theta_.noalias() += seen.transpose() * gain.residual;
  }
  if (!active_.allFinite()) throw DataError("the filter's state is not finite");
  return gain.Result();
}

Innovation CompressedEkf::Update(const Measurement& measurement, const SparseRows& kept) {
  Flush();
  Eigen::MatrixXd by_active = measurement.active * covariance_ + kept * cross_.transpose();
  Eigen::MatrixXd by_kept = measurement.active * cross_ + kept * kept_covariance_;
  Eigen::MatrixXd innovation =
      measurement.active * by_active.transpose() + kept * by_kept.transpose();
  innovation.diagonal() += measurement.variance;
  const auto factor = Factor(innovation);
  factor.matrixL().solveInPlace(by_active);
  factor.matrixL().solveInPlace(by_kept);
  const Eigen::VectorXd residual = factor.matrixL().solve(measurement.residual);
  Correct(by_active, residual);
  kept_.noalias() += by_kept.transpose() * residual;
  SubtractSquare(by_kept, &kept_covariance_);
  cross_.noalias() -= by_active.transpose() * by_kept;
  if (!active_.allFinite() || !kept_.allFinite()) {
    throw DataError("the filter's state is not finite");
  }
  return {residual.squaredNorm(), static_cast<int>(residual.size())};
}

void CompressedEkf::Keep(Eigen::Index first, Eigen::Index count) {
  Flush();
  const Eigen::Index num_kept = NumKept();
  const Eigen::Index num_rest = NumActive() - count;
  Eigen::MatrixXd kept_covariance(num_kept + count, num_kept + count);
  kept_covariance.topLeftCorner(num_kept, num_kept) = kept_covariance_;
  kept_covariance.bottomLeftCorner(count, num_kept) = cross_.middleRows(first, count);
  kept_covariance.topRightCorner(num_kept, count) = cross_.middleRows(first, count).transpose();
  kept_covariance.bottomRightCorner(count, count) = covariance_.block(first, first, count, count);
  kept_.conservativeResize(num_kept + count);
  kept_.tail(count) = active_.segment(first, count);
  kept_covariance_ = std::move(kept_covariance);

  Eigen::VectorXi rest(num_rest);
  for (Eigen::Index i = 0; i < num_rest; ++i) {
    rest[i] = static_cast<int>(i < first ? i : i + count);
  }
  Eigen::MatrixXd cross(num_rest, num_kept + count);
  cross.leftCols(num_kept) = cross_(rest, Eigen::all);
  cross.rightCols(count) = covariance_(rest, Eigen::seqN(first, count));
  cross_ = std::move(cross);
  active_ = active_(rest).eval();
  covariance_ = covariance_(rest, rest).eval();
  phi_.setIdentity(num_rest, num_rest);
  psi_.setZero(num_rest, num_rest);
  theta_.setZero(num_rest);
}

void CompressedEkf::Flush() {
  if (NumKept() == 0) return;
  kept_.noalias() += cross_.transpose() * theta_;
  const Eigen::MatrixXd lost = psi_.selfadjointView<Eigen::Lower>() * cross_;
  kept_covariance_.noalias() -= cross_.transpose() * lost;
  kept_covariance_ = 0.5 * (kept_covariance_ + kept_covariance_.transpose()).eval();
  cross_ = (phi_ * cross_).eval();
  phi_.setIdentity(NumActive(), NumActive());
  psi_.setZero(NumActive(), NumActive());
  theta_.setZero(NumActive());
}

const Eigen::VectorXd& CompressedEkf::Kept() {
  Flush();
  return kept_;
}

const Eigen::MatrixXd& CompressedEkf::KeptCovariance() {
  Flush();
  return kept_covariance_;
}

const Eigen::MatrixXd& CompressedEkf::CrossCovariance() {
  Flush();
  return cross_;
}

}  // namespace nightmap
