// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/moving_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace nightmap {
namespace {

using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

// A left perturbation of the pose (rotation, translation), then the motion (turn, shift).
struct State {
  Rigid3 camera_from_world;
  ReadoutMotion motion;

  State Stepped(const Vector12d& step) const {
    return {PerturbLeft(step.head<6>(), camera_from_world),
            {motion.turn_rad + step.segment<3>(6), motion.shift_m + step.tail<3>()}};
  }
};

struct NormalEquations {
  Matrix12d hessian = Matrix12d::Zero();
  Vector12d gradient = Vector12d::Zero();
  double cost = 0;
};

class MovingPoseProblem {
 public:
  MovingPoseProblem(const Camera& camera,
                    const std::vector<PointMatch>& matches,
                    const MovingPoseOptions& options)
      : camera_(camera), matches_(matches), options_(options) {}

  std::vector<int> Inliers(const State& state, double max_error_px) const {
    std::vector<int> inliers;
    for (std::size_t i = 0; i < matches_.size(); ++i) {
      if (Error_px(state, matches_[i]) <= max_error_px) inliers.push_back(static_cast<int>(i));
    }
    return inliers;
  }

  // Levenberg-Marquardt.
  State Refine(State state, const std::vector<int>& inliers) const {
    constexpr int kNumSteps = 10;
    constexpr double kMinGain = 1e-6;  // relative
    NormalEquations equations = Build(state, inliers);
    double damping = 1e-4;
    for (int step = 0; step < kNumSteps; ++step) {
      Matrix12d damped = equations.hessian;
      damped.diagonal() *= 1 + damping;
      const Vector12d update = -damped.ldlt().solve(equations.gradient);
      if (!update.allFinite()) break;
      const State candidate = state.Stepped(update);
      const NormalEquations there = Build(candidate, inliers);
      if (!(there.cost < equations.cost)) {  // nor where it is not a number
        damping *= 10;
        continue;
      }
      const bool is_done = there.cost > (1 - kMinGain) * equations.cost;
      state = candidate;
      equations = there;
      if (is_done) break;
      damping = std::max(1e-9, damping / 10);
    }
    return state;
  }

  // Nothing when the inliers do not determine the pose.
  std::optional<AbsolutePose> Finish(const State& state) const {
    AbsolutePose pose;
    pose.camera_from_world = state.camera_from_world;
    pose.inliers = Inliers(state, options_.max_error_px);
    const Eigen::LDLT<Matrix12d> factors(Build(state, pose.inliers).hessian);
    if (factors.info() != Eigen::Success || factors.vectorD().minCoeff() < 1e-6) return {};
    pose.covariance = factors.solve(Matrix12d::Identity()).topLeftCorner<6, 6>();
    double sum = 0;
    for (const int i : pose.inliers) {
      sum += std::pow(Error_px(state, matches_[static_cast<std::size_t>(i)]), 2);
    }
    pose.rms_error_px = std::sqrt(sum / static_cast<double>(pose.inliers.size()));
    return pose;
  }

 private:
  double Row(const PointMatch& match) const {
    return match.pixel.y() / std::max(1, camera_.height - 1) - 0.5;
  }

  double Error_px(const State& state, const PointMatch& match) const {
    const Eigen::Vector3d p =
        state.motion.Move(state.camera_from_world * match.point_in_world, Row(match));
    if (p.z() <= 1e-3) return std::numeric_limits<double>::infinity();
    return (*camera_.ProjectUndistorted(p) - match.pixel).norm();
  }

  NormalEquations Build(const State& state, const std::vector<int>& inliers) const {
    NormalEquations equations;
    for (const int i : inliers) Add(state, matches_[static_cast<std::size_t>(i)], &equations);
    Vector12d weights = Vector12d::Zero();
    weights.segment<3>(6).setConstant(1 / std::pow(options_.turn_sigma_rad, 2));
    weights.tail<3>().setConstant(1 / std::pow(options_.shift_sigma_m, 2));
    Vector12d motion = Vector12d::Zero();
    motion.tail<6>() << state.motion.turn_rad, state.motion.shift_m;
    equations.hessian.diagonal() += weights;
    equations.gradient += weights.cwiseProduct(motion);
    equations.cost += motion.dot(weights.cwiseProduct(motion));
    return equations;
  }

  // Residuals over their standard deviation, with Cauchy's robust weight.
  void Add(const State& state, const PointMatch& match, NormalEquations* equations) const {
    const double row = Row(match);
    const Eigen::Vector3d in_middle = state.camera_from_world * match.point_in_world;
    const Eigen::Vector3d p = state.motion.Move(in_middle, row);
    if (p.z() <= 1e-3) return;
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << camera_.fx / p.z(), 0, -camera_.fx * p.x() / (p.z() * p.z()),  //
        0, camera_.fy / p.z(), -camera_.fy * p.y() / (p.z() * p.z());
    by_point /= options_.pixel_sigma_px;
    const Eigen::Matrix<double, 2, 3> by_middle =
        by_point * (Eigen::Matrix3d::Identity() + row * Skew(state.motion.turn_rad));
    Eigen::Matrix<double, 2, 12> jacobian;
    jacobian << -by_middle * Skew(in_middle), by_middle, -row * by_point * Skew(in_middle),
        row * by_point;
    const Eigen::Vector2d residual =
        (*camera_.ProjectUndistorted(p) - match.pixel) / options_.pixel_sigma_px;
    constexpr double kScale2 = 4.0;  // Cauchy's constant is 2 standard deviations
    const double weight = 1 / (1 + residual.squaredNorm() / kScale2);
    equations->hessian += weight * jacobian.transpose() * jacobian;
    equations->gradient += weight * jacobian.transpose() * residual;
    equations->cost += kScale2 * std::log1p(residual.squaredNorm() / kScale2);
  }

  const Camera& camera_;
  const std::vector<PointMatch>& matches_;
  const MovingPoseOptions& options_;
};

}  // namespace

std::optional<MovingPose> RefineMovingPose(const Camera& camera,
                                           const std::vector<PointMatch>& matches,
                                           const Rigid3& camera_from_world,
                                           int min_inliers,
                                           const MovingPoseOptions& options) {
  constexpr int kNumRounds = 3;
  constexpr double kWider = 1.5;  // a motion not known yet hides inliers at the first and last rows
  const MovingPoseProblem problem(camera, matches, options);
  State state{camera_from_world, {}};
  for (int round = 0; round < kNumRounds; ++round) {
    state = problem.Refine(state, problem.Inliers(state, kWider * options.max_error_px));
  }
  auto pose = problem.Finish(state);
  if (!pose || static_cast<int>(pose->inliers.size()) < min_inliers) return {};
  return MovingPose{*std::move(pose), state.motion};
}

}  // namespace nightmap
