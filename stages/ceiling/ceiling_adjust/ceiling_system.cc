// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/ceiling_system.h"

#include <Eigen/LU>
#include <algorithm>

namespace nightmap {
namespace {

constexpr Eigen::Index kWheels = 5, kLevel = 7;  // first unknown, of those that all share
}  // namespace

std::vector<KeyframeView> ViewsOf(const CeilingProblem& problem, const CeilingUnknowns& unknowns) {
  std::vector<KeyframeView> views;
  views.reserve(unknowns.keyframes.size());
  for (const Vector5d& keyframe : unknowns.keyframes) {
    views.emplace_back(problem, keyframe, unknowns.mounting);
  }
  return views;
}

CeilingSystem::CeilingSystem(const CeilingNoise& noise,
                             const CeilingProblem& problem,
                             const IndexGroups& sightings_of_point,
                             const std::vector<std::vector<int>>& neighbours,
                             std::size_t num_points)
    : noise_(noise),
      problem_(problem),
      of_point_(sightings_of_point),
      is_level_(num_points, false),
      pattern_(
          MakeBlockPattern(std::vector<bool>(neighbours.size(), true), neighbours, kSize, kCommon)),
      cholesky_("use a machine with more memory, or raise ceiling_adjust.keyframe_distance_m") {
  if (problem.level) {
    for (const std::size_t point : problem.level->points) is_level_[point] = true;
  }
  cholesky_.Analyze(pattern_.lower);
}

Eigen::Map<Eigen::MatrixXd> CeilingSystem::ColumnsOf(std::size_t keyframe) {
  const int* const columns = pattern_.lower.outerIndexPtr() + kSize * RankOf(keyframe);
  return {pattern_.lower.valuePtr() + columns[0], columns[1] - columns[0], kSize};
}

Eigen::Map<CeilingSystem::CommonMatrix> CeilingSystem::CommonBlock() {
  return Eigen::Map<CommonMatrix>(pattern_.lower.valuePtr() + pattern_.lower.nonZeros() -
                                  kCommon * kCommon);
}

std::optional<CeilingStep> CeilingSystem::Step(const CeilingUnknowns& unknowns,
                                               const CauchyLoss& sighting_loss,
                                               double damping) {
  const std::vector<KeyframeView> views = ViewsOf(problem_, unknowns);
  const Estimate estimate{unknowns, views, sighting_loss, damping};
  Clear();
  AddMotions(unknowns);
  AddExpected(unknowns);
  for (std::size_t point = 0; point < is_level_.size(); ++point) {
    LoadPoint(estimate, point, true);
    EliminatePoint();
  }
  Damp(damping);
  const auto solution = cholesky_.Solve(pattern_.lower, eliminated_ - gradient_);
  if (!solution || !solution->allFinite()) return {};
  return StepOf(estimate, *solution);
}

void CeilingSystem::Clear() {
  std::fill_n(pattern_.lower.valuePtr(), pattern_.lower.nonZeros(), 0.0);
  curvature_ = gradient_ = eliminated_ = Eigen::VectorXd::Zero(pattern_.lower.rows());
  expected_gain_ = 0;
}

// Row of a block in the columns of the keyframe that is eliminated earlier; not before `first`.
Eigen::Index CeilingSystem::BlockRow(std::size_t earlier, int later_rank, Eigen::Index first) {
  const int* const columns = pattern_.lower.outerIndexPtr() + kSize * RankOf(earlier);
  const int* const rows = pattern_.lower.innerIndexPtr() + columns[0];
  const int* const end = rows + (columns[1] - columns[0]) - kCommon;
  return std::lower_bound(rows + first, end, kSize * later_rank) - rows;
}

template <int kRows>
void CeilingSystem::Add(std::size_t keyframe,
                        double weight,
                        const Eigen::Matrix<double, kRows, kSize>& by_keyframe,
                        const Eigen::Matrix<double, kRows, kCommon>& by_common,
                        const Eigen::Matrix<double, kRows, 1>& residual) {
  const Eigen::Matrix<double, kSize, kRows> weighted = weight * by_keyframe.transpose();
  const Matrix5d own = weighted * by_keyframe;
  auto columns = ColumnsOf(keyframe);
  columns.topRows<kSize>() += own;
  columns.bottomRows<kCommon>() += by_common.transpose() * weighted.transpose();
  curvature_.segment<kSize>(kSize * RankOf(keyframe)) += own.diagonal();
  gradient_.segment<kSize>(kSize * RankOf(keyframe)) += weighted * residual;
}

template <int kRows>
void CeilingSystem::AddCommon(double weight,
                              const Eigen::Matrix<double, kRows, kCommon>& by_common,
                              const Eigen::Matrix<double, kRows, 1>& residual) {
  const CommonMatrix own = weight * by_common.transpose() * by_common;
  CommonBlock() += own;
  curvature_.tail<kCommon>() += own.diagonal();
  gradient_.tail<kCommon>() += weight * by_common.transpose() * residual;
}

void CeilingSystem::AddMotions(const CeilingUnknowns& unknowns) {
  for (const KeyframeMotion& motion : problem_.motions) {
    const std::size_t before = motion.start, after = motion.start + 1;
    const LinearMotion linear = LinearizeMotion(noise_,
                                                motion,
                                                unknowns.keyframes[before].head<3>(),
                                                unknowns.keyframes[after].head<3>(),
                                                unknowns.wheels);
    const double weight = kWheelLoss.Weight(linear.residual.squaredNorm());
    Eigen::Matrix<double, 3, kSize> by_before, by_after;
    by_before << linear.by_before, Eigen::Matrix<double, 3, 2>::Zero();
    by_after << linear.by_after, Eigen::Matrix<double, 3, 2>::Zero();
    if (before == 0) by_before.setZero();  // the first pose stays
    Matrix3Common by_common = Matrix3Common::Zero();
    by_common.middleCols<2>(kWheels) = linear.by_wheels;
    Add<3>(before, weight, by_before, by_common, linear.residual);
    Add<3>(after, weight, by_after, by_common, linear.residual);
    AddCommon<3>(weight, by_common, linear.residual);
    const Matrix5d after_before = weight * by_after.transpose() * by_before;
    if (RankOf(before) < RankOf(after)) {
      ColumnsOf(before).middleRows<kSize>(BlockRow(before, RankOf(after), 0)) += after_before;
    } else {
      ColumnsOf(after).middleRows<kSize>(BlockRow(after, RankOf(before), 0)) +=
          after_before.transpose();
    }
  }
}

void CeilingSystem::AddExpected(const CeilingUnknowns& unknowns) {
  for (std::size_t k = 0; k < unknowns.keyframes.size(); ++k) {
    const ExpectedTilt expected(noise_, unknowns.keyframes[k]);
    const Eigen::Index first = kSize * RankOf(k);
    ColumnsOf(k).diagonal().segment<2>(3).array() += expected.information;
    curvature_.segment<2>(first + 3).array() += expected.information;
    gradient_.segment<2>(first + 3) += expected.information * expected.difference;
  }
  const ExpectedCommon expected(noise_, problem_, unknowns);
  CommonBlock().diagonal() += expected.information;
  curvature_.tail<kCommon>() += expected.information;
  gradient_.tail<kCommon>() += expected.information.cwiseProduct(expected.difference);
}

void CeilingSystem::LoadPoint(const Estimate& estimate, std::size_t index, bool is_new) {
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();
  point_.gradient.setZero();
  point_.by_common.setZero();
  point_.seen.clear();
  const Eigen::Vector3d& position = estimate.unknowns.points[index];
  for (const int s : of_point_.Of(index)) {
    const PointSighting& sighting = problem_.sightings[static_cast<std::size_t>(s)];
    const std::size_t keyframe = sighting.keyframe;
    auto linear =
        estimate.views[keyframe].Linearize(position, sighting.pixel, noise_.pixel_sigma_px);
    if (keyframe == 0) linear.by_keyframe.leftCols<3>().setZero();  // the first pose stays
    const double weight = estimate.loss.Weight(linear.residual.squaredNorm());
    Eigen::Matrix<double, 2, kCommon> by_common = Eigen::Matrix<double, 2, kCommon>::Zero();
    by_common.leftCols<5>() = linear.by_mounting;
    const Eigen::Matrix<double, 3, 2> weighted = weight * linear.by_point.transpose();
    curvature += weighted * linear.by_point;
    point_.gradient += weighted * linear.residual;
    point_.by_common += weighted * by_common;
    if (point_.seen.empty() || point_.seen.back().keyframe != keyframe) {
      point_.seen.push_back({keyframe, Matrix53d::Zero()});
    }
    point_.seen.back().by_point += linear.by_keyframe.transpose() * weighted.transpose();
    if (!is_new) continue;
    Add<2>(keyframe, weight, linear.by_keyframe, by_common, linear.residual);
    AddCommon<2>(weight, by_common, linear.residual);
  }
  if (is_level_[index]) AddLevel(estimate.unknowns, index, is_new, &curvature);
  curvature.diagonal() *= 1 + estimate.damping;
  point_.inverse = curvature.inverse();
}

void CeilingSystem::AddLevel(const CeilingUnknowns& unknowns,
                             std::size_t index,
                             bool is_new,
                             Eigen::Matrix3d* curvature) {
  const double error = (unknowns.points[index].z() - unknowns.level_m) / kLevelSigma_m;
  const double weight = kLevelLoss.Weight(error * error);
  const double information = weight / (kLevelSigma_m * kLevelSigma_m);
  (*curvature)(2, 2) += information;
  point_.gradient.z() += weight * error / kLevelSigma_m;
  point_.by_common(2, kLevel) -= information;
  if (!is_new) return;
  Eigen::Matrix<double, 1, kCommon> by_common = Eigen::Matrix<double, 1, kCommon>::Zero();
  by_common[kLevel] = -1 / kLevelSigma_m;
  AddCommon<1>(weight, by_common, Eigen::Matrix<double, 1, 1>(error));
}

void CeilingSystem::EliminatePoint() {
  if (point_.seen.empty()) return;
  std::ranges::sort(point_.seen, {}, [&](const auto& seen) { return RankOf(seen.keyframe); });
  const Eigen::Vector3d step = point_.inverse * point_.gradient;
  expected_gain_ += point_.gradient.dot(step) / 2;
  for (std::size_t i = 0; i < point_.seen.size(); ++i) {
    const auto& [keyframe, by_point] = point_.seen[i];
    auto columns = ColumnsOf(keyframe);
    const Eigen::Matrix<double, 3, kSize> gain = point_.inverse * by_point.transpose();
    Eigen::Index row = 0;
    for (std::size_t j = i; j < point_.seen.size(); ++j) {
      row = BlockRow(keyframe, RankOf(point_.seen[j].keyframe), row);
      columns.middleRows<kSize>(row).noalias() -= point_.seen[j].by_point.lazyProduct(gain);
    }
    columns.bottomRows<kCommon>() -= point_.by_common.transpose() * gain;
    eliminated_.segment<kSize>(kSize * RankOf(keyframe)) += by_point * step;
  }
  CommonBlock() -= point_.by_common.transpose() * point_.inverse * point_.by_common;
  eliminated_.tail<kCommon>() += point_.by_common.transpose() * step;
}

void CeilingSystem::Damp(double damping) {
  // Unknowns that nothing measures, such as the first pose, stay.
  const Eigen::VectorXd added =
      (curvature_.array() > 0).select(damping * curvature_.array(), 1).matrix();
  for (std::size_t k = 0; k < pattern_.rank.size(); ++k) {
    ColumnsOf(k).diagonal() += added.segment<kSize>(kSize * RankOf(k));
  }
  CommonBlock().diagonal() += added.tail<kCommon>();
}

CeilingStep CeilingSystem::StepOf(const Estimate& estimate, const Eigen::VectorXd& solution) {
  CeilingStep step;
  step.expected_gain = expected_gain_ + (eliminated_ - gradient_).dot(solution) / 2;
  for (const int rank : pattern_.rank) {
    step.keyframes.emplace_back(solution.segment<kSize>(kSize * rank));
  }
  const CommonVector common = solution.tail<kCommon>();
  step.mounting = common.head<5>();
  step.wheels = common.segment<2>(kWheels);
  step.level_m = common[kLevel];
  for (std::size_t point = 0; point < is_level_.size(); ++point) {
    LoadPoint(estimate, point, false);
    Eigen::Vector3d gradient = point_.gradient + point_.by_common * common;
    for (const auto& [keyframe, by_point] : point_.seen) {
      gradient += by_point.transpose() * step.keyframes[keyframe];
    }
    step.points.emplace_back(Eigen::Vector3d::Zero());
    if (!point_.seen.empty()) step.points.back() = -point_.inverse * gradient;
  }
  return step;
}

}  // namespace nightmap
