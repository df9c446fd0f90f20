// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/optimize_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/geometry/without_openmp.h"

namespace nightmap {
namespace {

// Difference of the predicted and the measured b_from_a as a left perturbation, over its standard
// deviation: residual = L (rotation vector, translation) with L^T L the information.
class EdgeError {
 public:
  // `sqrt_information` must outlive this.
  EdgeError(const PoseEdge& edge, const Matrix6d& sqrt_information, double weight)
      : a_from_b_(edge.b_from_a.Inverse()),
        sqrt_information_(sqrt_information),
        sqrt_weight_(std::sqrt(weight)) {}

  static Matrix6d SqrtInformation(const PoseEdge& edge) {
    const Matrix6d information = edge.covariance.llt().solve(Matrix6d::Identity());
    return information.llt().matrixU();
  }

  template <typename T>
  bool operator()(const T* rotation_a,
                  const T* translation_a,
                  const T* rotation_b,
                  const T* translation_b,
                  T* residual) const {
    using Quaternion = Eigen::Quaternion<T>;
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Quaternion> world_from_a_rotation(rotation_a);
    const Eigen::Map<const Quaternion> world_from_b_rotation(rotation_b);
    const Eigen::Map<const Vector> world_from_a_translation(translation_a);
    const Eigen::Map<const Vector> world_from_b_translation(translation_b);
    const Quaternion b_from_world = world_from_b_rotation.conjugate();
    const Quaternion b_from_a = b_from_world * world_from_a_rotation;
    const Vector b_from_a_translation =
        b_from_world * (world_from_a_translation - world_from_b_translation);
    const Quaternion difference = b_from_a * a_from_b_.rotation.cast<T>();
    const Vector difference_translation =
        b_from_a * a_from_b_.translation.cast<T>() + b_from_a_translation;
    const T sign = difference.w() < T(0) ? T(-2) : T(2);
    Eigen::Matrix<T, 6, 1> error;
    error << sign * difference.vec(), difference_translation;
    const Matrix6d sqrt_information = sqrt_weight_ * sqrt_information_;
    Eigen::Map<Eigen::Matrix<T, 6, 1>>(residual).noalias() = sqrt_information * error;
    return true;
  }

 private:
  Rigid3 a_from_b_;
  const Matrix6d& sqrt_information_;
  double sqrt_weight_;
};

// L of each edge.
std::vector<Matrix6d> SqrtInformation(const std::vector<GraphEdge>& edges) {
  std::vector<Matrix6d> all;
  all.reserve(edges.size());
  for (const GraphEdge& edge : edges) all.push_back(EdgeError::SqrtInformation(edge.edge));
  return all;
}

GraphSummary Solve(const std::vector<GraphEdge>& edges,
                   const std::vector<Matrix6d>& sqrt_information,
                   std::map<int, Rigid3>* poses) {
  ceres::Problem problem;
  auto* const rotations = new ceres::EigenQuaternionManifold;
  for (auto& [frame_idx, pose] : *poses) {
    problem.AddParameterBlock(pose.rotation.coeffs().data(), 4, rotations);
    problem.AddParameterBlock(pose.translation.data(), 3);
  }
  // Only relative poses are measured, so one pose is held fixed; otherwise the whole graph could
  // move.
  Rigid3& first = poses->begin()->second;
  problem.SetParameterBlockConstant(first.rotation.coeffs().data());
  problem.SetParameterBlockConstant(first.translation.data());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const GraphEdge& edge = edges[i];
    if (edge.weight < 1e-6) continue;
    Rigid3& a = poses->at(edge.edge.frame_a);
    Rigid3& b = poses->at(edge.edge.frame_b);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<EdgeError, 6, 4, 3, 4, 3>(
                                 new EdgeError(edge.edge, sqrt_information[i], edge.weight)),
                             nullptr,
                             a.rotation.coeffs().data(),
                             a.translation.data(),
                             b.rotation.coeffs().data(),
                             b.translation.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 30;
  options.function_tolerance = 1e-6;
  options.num_threads = 1;  // parallel sums would make the result depend on the schedule
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    throw DataError(
        "the graph of {} keyframes and {} edges was not optimized: {}; where memory is short use a "
        "machine with more, else delete the odometry and matches folders of this site and run make",
        poses->size(),
        edges.size(),
        summary.message);
  }
  for (auto& [frame_idx, pose] : *poses) pose.rotation.normalize();
  return {0,
          summary.initial_cost,
          summary.final_cost,
          static_cast<int>(summary.iterations.size()) - 1,
          ceres::TerminationTypeToString(summary.termination_type)};
}

double ErrorOf(const PoseEdge& edge,
               const Matrix6d& sqrt_information,
               const Rigid3& world_from_a,
               const Rigid3& world_from_b) {
  Vector6d residual;
  EdgeError(edge, sqrt_information, 1)(world_from_a.rotation.coeffs().data(),
                                       world_from_a.translation.data(),
                                       world_from_b.rotation.coeffs().data(),
                                       world_from_b.translation.data(),
                                       residual.data());
  return residual.norm();
}

void UpdateErrors(const std::map<int, Rigid3>& poses,
                  const std::vector<Matrix6d>& sqrt_information,
                  std::vector<GraphEdge>* edges) {
  for (std::size_t i = 0; i < edges->size(); ++i) {
    const PoseEdge& edge = (*edges)[i].edge;
    (*edges)[i].error =
        ErrorOf(edge, sqrt_information[i], poses.at(edge.frame_a), poses.at(edge.frame_b));
  }
}

// Equation 14 of the paper: the weight of a truncated squared error at control value mu.
double Weight(double error, double max_error, double mu) {
  const double error2 = error * error;
  const double max_error2 = max_error * max_error;
  if (error2 >= (mu + 1) / mu * max_error2) return 0;
  if (error2 <= mu / (mu + 1) * max_error2) return 1;
  return max_error / error * std::sqrt(mu * (mu + 1)) - mu;
}

bool AllDecided(const std::vector<GraphEdge>& edges) {
  return std::ranges::all_of(edges, [](const GraphEdge& edge) {
    return !edge.is_loop || edge.weight < 1e-3 || edge.weight > 1 - 1e-3;
  });
}

}  // namespace

double ErrorOf(const PoseEdge& edge, const Rigid3& world_from_a, const Rigid3& world_from_b) {
  return ErrorOf(edge, EdgeError::SqrtInformation(edge), world_from_a, world_from_b);
}

GraphSummary OptimizeGraph(double max_loop_error,
                           std::vector<GraphEdge>* edges,
                           std::map<int, Rigid3>* poses) {
  constexpr int kMaxRounds = 40;
  constexpr double kMuFactor = 1.6;
  const std::vector<Matrix6d> sqrt_information = SqrtInformation(*edges);
  const WithoutOpenMp without_open_mp;
  double worst = 0;
  UpdateErrors(*poses, sqrt_information, edges);
  for (const GraphEdge& edge : *edges) {
    if (edge.is_loop) worst = std::max(worst, edge.error);
  }
  const double denominator = 2 * worst * worst - max_loop_error * max_loop_error;
  double mu = denominator > 0 ? std::max(1e-6, max_loop_error * max_loop_error / denominator) : 1e6;
  int num_rounds = 0;
  while (num_rounds < kMaxRounds) {
    Solve(*edges, sqrt_information, poses);
    UpdateErrors(*poses, sqrt_information, edges);
    for (GraphEdge& edge : *edges) {
      if (edge.is_loop) edge.weight = Weight(edge.error, max_loop_error, mu);
    }
    if (++num_rounds > 1 && AllDecided(*edges)) break;
    mu *= kMuFactor;
  }
  for (GraphEdge& edge : *edges) {
    if (edge.is_loop) edge.weight = edge.error <= max_loop_error ? 1 : 0;
  }
  GraphSummary summary = Solve(*edges, sqrt_information, poses);
  summary.num_rounds = num_rounds;
  UpdateErrors(*poses, sqrt_information, edges);
  return summary;
}

}  // namespace nightmap
