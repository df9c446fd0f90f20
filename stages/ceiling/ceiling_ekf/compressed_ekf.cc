// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/compressed_ekf.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <utility>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

constexpr double kRankTolerance = 1e-10;

void MakeSymmetric(Eigen::MatrixXd* matrix) {
  matrix->triangularView<Eigen::StrictlyUpper>() = matrix->transpose();
}

// Rows times a symmetric matrix whose lower triangle this is.
Eigen::MatrixXd TimesSymmetric(const SparseRows& rows,
                               const Eigen::Ref<const Eigen::MatrixXd>& lower) {
  const Eigen::Index size = lower.cols();
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(rows.rows(), size);
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    for (SparseRows::InnerIterator entry(rows, row); entry; ++entry) {
      const Eigen::Index i = entry.col();
      product.row(row).head(i) += entry.value() * lower.row(i).head(i);
      product.row(row).tail(size - i) += entry.value() * lower.col(i).tail(size - i).transpose();
    }
  }
  return product;
}

Eigen::MatrixXd Factor(const Eigen::MatrixXd& innovation_covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(innovation_covariance);
  if (factor.info() == Eigen::Success && innovation_covariance.allFinite()) {
    return factor.matrixL();
  }
  throw DataError("the covariance of a measurement is not positive definite");
}

void CheckFinite(const Eigen::VectorXd& state) {
  if (!state.allFinite()) throw DataError("the filter's state is not finite");
}

}  // namespace

CompressedEkf::CompressedEkf(Eigen::VectorXd mean,
                             Eigen::MatrixXd covariance,
                             Eigen::Index considered)
    : considered_(considered), active_(std::move(mean)), covariance_(std::move(covariance)) {
  kept_ = std::make_shared<KeptPart>();
  kept_->cross.resize(active_.size(), 0);
}

void CompressedEkf::Transform(Eigen::VectorXd mean,
                              const SparseRows& jacobian,
                              const SparseRows& noise) {
  active_ = std::move(mean);
  const Eigen::MatrixXd half = (jacobian * covariance_).transpose();
  covariance_.noalias() = jacobian * half;
  covariance_ += noise;
  MakeSymmetric(&covariance_);
  if (IsDeferred()) {
    phi_ = (jacobian * phi_).eval();
  } else {
    KeptPart& part = Own();
    part.cross = (jacobian * part.cross).eval();
  }
}

void CompressedEkf::Select(const std::vector<Eigen::Index>& rest) {
  active_ = active_(rest).eval();
  covariance_ = covariance_(rest, rest).eval();
  if (IsDeferred()) {
    phi_ = phi_(rest, Eigen::all).eval();
  } else {
    KeptPart& part = Own();
    part.cross = part.cross(rest, Eigen::all).eval();
  }
}

void CompressedEkf::KeptPart::Grow(Eigen::Index count) {
  const Eigen::Index size = mean.size() + count;
  mean.conservativeResize(size);
  if (size > triangle.rows()) {
    const Eigen::Index room = size + size / 4;
    triangle.conservativeResize(room, room);
  }
}

CompressedEkf::KeptPart& CompressedEkf::Own() {
  if (kept_.use_count() > 1) kept_ = std::make_shared<KeptPart>(*kept_);
  return *kept_;
}

CompressedEkf::Gain CompressedEkf::Solve(const Measurement& measurement) const {
  Gain gain;
  gain.root = measurement.active * covariance_;
  Eigen::MatrixXd innovation = measurement.active * gain.root.transpose();
  innovation.diagonal() += measurement.variance;
  gain.factor = Factor(innovation);
  const auto lower = gain.factor.triangularView<Eigen::Lower>();
  lower.solveInPlace(gain.root);
  gain.residual = lower.solve(measurement.residual);
  return gain;
}

Innovation CompressedEkf::Correct(const Gain& gain) {
  const double mean = considered_ < 0 ? 0 : active_[considered_];
  const double variance = considered_ < 0 ? 0 : covariance_(considered_, considered_);
  active_.noalias() += gain.root.transpose() * gain.residual;
  covariance_.selfadjointView<Eigen::Lower>().rankUpdate(gain.root.transpose(), -1);
  MakeSymmetric(&covariance_);
  if (considered_ >= 0) {
    active_[considered_] = mean;
    covariance_(considered_, considered_) = variance;
  }
  CheckFinite(active_);
  return {gain.residual.squaredNorm(), static_cast<int>(gain.residual.size())};
}

std::vector<double> CompressedEkf::Test(const Measurement& measurement, Eigen::Index size) const {
  const Eigen::MatrixXd by_state = measurement.active * covariance_;
  std::vector<double> squared;
  for (Eigen::Index first = 0; first < measurement.residual.size(); first += size) {
    Eigen::MatrixXd innovation =
        measurement.active.middleRows(first, size) * by_state.middleRows(first, size).transpose();
    innovation.diagonal() += measurement.variance.segment(first, size);
    const Eigen::VectorXd residual = Factor(innovation)
                                         .triangularView<Eigen::Lower>()
                                         .solve(measurement.residual.segment(first, size));
    squared.push_back(residual.squaredNorm());
  }
  return squared;
}

Innovation CompressedEkf::Update(const Measurement& measurement) {
  if (!IsDeferred()) {
    return Update(measurement, SparseRows(measurement.residual.size(), NumKept()));
  }
  const Gain gain = Solve(measurement);
  Eigen::MatrixXd seen = measurement.active * phi_;
  gain.factor.triangularView<Eigen::Lower>().solveInPlace(seen);
  phi_.noalias() -= gain.root.transpose() * seen;
  psi_.selfadjointView<Eigen::Lower>().rankUpdate(seen.transpose());
  theta_.noalias() += seen.transpose() * gain.residual;
  return Correct(gain);
}

Innovation CompressedEkf::Update(const Measurement& measurement, const SparseRows& kept) {
  Flush();
  Gain gain;
  gain.root = measurement.active * covariance_ + kept * kept_->cross.transpose();
  Eigen::MatrixXd by_kept =
      measurement.active * kept_->cross + TimesSymmetric(kept, kept_->Lower());
  Eigen::MatrixXd innovation =
      measurement.active * gain.root.transpose() + kept * by_kept.transpose();
  innovation.diagonal() += measurement.variance;
  gain.factor = Factor(innovation);
  const auto lower = gain.factor.triangularView<Eigen::Lower>();
  lower.solveInPlace(gain.root);
  lower.solveInPlace(by_kept);
  gain.residual = lower.solve(measurement.residual);
  if (NumKept() > 0) {
    KeptPart& part = Own();
    part.mean.noalias() += by_kept.transpose() * gain.residual;
    part.Lower().selfadjointView<Eigen::Lower>().rankUpdate(by_kept.transpose(), -1);
    part.cross.noalias() -= gain.root.transpose() * by_kept;
    CheckFinite(part.mean);
  }
  const Innovation innovation_squared = Correct(gain);
  Defer();
  return innovation_squared;
}

void CompressedEkf::Keep(Eigen::Index first, Eigen::Index count) {
  Flush();
  const Eigen::Index num_kept = NumKept();
  std::vector<Eigen::Index> rest;
  for (Eigen::Index i = 0; i < NumActive(); ++i) {
    if (i < first || i >= first + count) rest.push_back(i);
  }
  KeptPart& part = Own();
  part.Grow(count);
  part.mean.tail(count) = active_.segment(first, count);
  part.Lower().bottomLeftCorner(count, num_kept) = part.cross.middleRows(first, count);
  part.Lower().bottomRightCorner(count, count) = covariance_.block(first, first, count, count);
  Eigen::MatrixXd cross(static_cast<Eigen::Index>(rest.size()), num_kept + count);
  cross << part.cross(rest, Eigen::all), covariance_(rest, Eigen::seqN(first, count));
  part.cross = std::move(cross);
  active_ = active_(rest).eval();
  covariance_ = covariance_(rest, rest).eval();
  Defer();
}

void CompressedEkf::Defer() {
  if (NumKept() == 0) return;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(kept_->cross);
  factors.setThreshold(kRankTolerance);
  const Eigen::Index rank = factors.rank();
  if (rank == 0 || 2 * rank > NumKept()) return;
  Own().cross = Eigen::MatrixXd(factors.matrixR().topRows(rank).triangularView<Eigen::Upper>()) *
                factors.colsPermutation().transpose();
  phi_ = factors.householderQ() * Eigen::MatrixXd::Identity(NumActive(), rank);
  psi_.setZero(rank, rank);
  theta_.setZero(rank);
}

void CompressedEkf::Flush() {
  if (!IsDeferred()) return;
  KeptPart& part = Own();
  part.mean.noalias() += part.cross.transpose() * theta_;
  const Eigen::MatrixXd lost = psi_.selfadjointView<Eigen::Lower>() * part.cross;
  part.Lower().triangularView<Eigen::Lower>() -= part.cross.transpose() * lost;
  part.cross = (phi_ * part.cross).eval();
  phi_.resize(0, 0);
  psi_.resize(0, 0);
  theta_.resize(0);
}

const Eigen::VectorXd& CompressedEkf::Kept() {
  Flush();
  return kept_->mean;
}

Eigen::MatrixXd CompressedEkf::KeptCovariance(Eigen::Index first, Eigen::Index count) {
  Flush();
  return kept_->Lower().block(first, first, count, count).selfadjointView<Eigen::Lower>();
}

const Eigen::MatrixXd& CompressedEkf::CrossCovariance() {
  Flush();
  return kept_->cross;
}

}  // namespace nightmap
