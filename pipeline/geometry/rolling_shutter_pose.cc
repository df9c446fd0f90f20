// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/rolling_shutter_pose.h"

#include <cmath>
#include <limits>

#include "pipeline/geometry/levenberg_marquardt.h"

namespace nightmap {
namespace {

constexpr int kFocal = 12;  // index of the focal length among the unknowns

// A left perturbation of the pose (rotation, translation), then the motion (turn, shift), then the
// logarithm of the focal length.
struct MovingState {
  Rigid3 camera_from_world;
  ReadoutMotion motion;
  double log_focal_scale = 0;

  template <int kSize>
  MovingState Stepped(const Eigen::Matrix<double, kSize, 1>& step) const {
    return {PerturbLeft(step.template head<6>(), camera_from_world),
            {motion.turn_rad + step.template segment<3>(6),
             motion.shift_m + step.template segment<3>(9)},
            log_focal_scale + (kSize > kFocal ? step[kSize - 1] : 0)};
  }
};

// kSize: 12 unknowns, or 13 with the focal length.
template <int kSize>
class MovingPoseProblem {
 public:
  using Vector = Eigen::Matrix<double, kSize, 1>;
  static constexpr bool kHasFocal = kSize > kFocal;

  MovingPoseProblem(const Camera& camera,
                    const std::vector<PointMatch>& matches,
                    const MovingPoseOptions& options)
      : camera_(camera), matches_(matches), options_(options) {}

  std::vector<int> Inliers(const MovingState& state, double max_error_px) const {
    std::vector<int> inliers;
    for (std::size_t i = 0; i < matches_.size(); ++i) {
      if (Error_px(state, matches_[i]) <= max_error_px) inliers.push_back(static_cast<int>(i));
    }
    return inliers;
  }

  MovingState Refine(const MovingState& state, const std::vector<int>& inliers) const {
    return MinimizeSmall<kSize>(
        {.max_steps = 10, .min_gain = 1e-6},
        state,
        [&](const MovingState& at) { return Equations(at, inliers); },
        [](const Vector& step, const MovingState& at) { return at.Stepped<kSize>(step); });
  }

  // Nothing when the inliers do not determine the pose.
  std::optional<MovingPose> Finish(const MovingState& state) const {
    MovingPose result{{}, state.motion, std::exp(state.log_focal_scale)};
    AbsolutePose& pose = result.pose;
    pose.camera_from_world = state.camera_from_world;
    pose.inliers = Inliers(state, options_.max_error_px);
    const auto covariance = Equations(state, pose.inliers).Covariance();
    if (!covariance) return {};
    pose.covariance = covariance->template topLeftCorner<6, 6>();
    if constexpr (kHasFocal) result.focal_sigma_ratio = std::sqrt((*covariance)(kFocal, kFocal));
    double sum = 0;
    for (const int i : pose.inliers) {
      sum += std::pow(Error_px(state, matches_[static_cast<std::size_t>(i)]), 2);
    }
    pose.rms_error_px = std::sqrt(sum / static_cast<double>(pose.inliers.size()));
    return result;
  }

 private:
  Reprojection Reproject(const MovingState& state, const PointMatch& match) const {
    const CameraCalibration calibration{.focal_scale = std::exp(state.log_focal_scale),
                                        .readout_s = 1};
    return {camera_,
            state.camera_from_world * match.point_in_world,
            RowFraction(camera_, match.pixel),
            state.motion.PerReadout(),
            calibration};
  }

  double Error_px(const MovingState& state, const PointMatch& match) const {
    const Reprojection seen = Reproject(state, match);
    if (!seen.IsVisible()) return std::numeric_limits<double>::infinity();
    return seen.Residual({match.pixel}).head<2>().norm();
  }

  NormalEquations<kSize> Equations(const MovingState& state, const std::vector<int>& inliers) const {
    NormalEquations<kSize> equations;
    for (const int i : inliers) {
      const PointMatch& match = matches_[static_cast<std::size_t>(i)];
      const Reprojection seen = Reproject(state, match);
      if (!seen.IsVisible()) continue;
      const PointMeasurement measured{.pixel = match.pixel,
                                      .per_pixel_sigma = 1 / options_.pixel_sigma_px};
      const Eigen::Matrix3d by_p = seen.ByMovedPoint(measured);
      Eigen::Matrix<double, 2, kSize> jacobian;
      jacobian.template leftCols<6>() = seen.ByPose(seen.ByMiddlePoint(by_p)).topRows<2>();
      jacobian.template middleCols<6>(6) = seen.ByMotion(by_p).topRows<2>();
      if constexpr (kHasFocal) {
        jacobian.col(kFocal) = std::exp(state.log_focal_scale) *
                               seen.ByCalibration(measured, by_p).col(0).template head<2>();
      }
      equations.template AddRobust<2>(jacobian, seen.Residual(measured).template head<2>());
    }
    AddPriors(state, &equations);
    return equations;
  }

  void AddPriors(const MovingState& state, NormalEquations<kSize>* equations) const {
    Vector weights = Vector::Zero();
    weights.template segment<3>(6).setConstant(1 / std::pow(options_.turn_sigma_rad, 2));
    weights.template segment<3>(9).setConstant(1 / std::pow(options_.shift_sigma_m, 2));
    Vector motion = Vector::Zero();
    motion.template segment<6>(6) << state.motion.turn_rad, state.motion.shift_m;
    equations->AddPrior(weights, motion);
    if constexpr (kHasFocal) {
      Eigen::Matrix<double, 1, kSize> jacobian = Eigen::Matrix<double, 1, kSize>::Zero();
      jacobian[kFocal] = 1 / options_.focal_sigma_ratio;
      equations->template AddRobust<1>(
          jacobian,
          Eigen::Matrix<double, 1, 1>(state.log_focal_scale / options_.focal_sigma_ratio));
    }
  }

  const Camera& camera_;
  const std::vector<PointMatch>& matches_;
  const MovingPoseOptions& options_;
};

template <int kSize>
std::optional<MovingPose> RefineFrom(const MovingPoseProblem<kSize>& problem,
                                     MovingState state,
                                     int min_inliers,
                                     double max_error_px) {
  constexpr int kNumRounds = 3;
  // What is not known yet hides inliers: a motion those at the first and last rows, a focal length
  // those at the borders.
  constexpr double kWider = 1.5;
  for (int round = 0; round < kNumRounds; ++round) {
    state = problem.Refine(state, problem.Inliers(state, kWider * max_error_px));
  }
  auto pose = problem.Finish(state);
  if (!pose || static_cast<int>(pose->pose.inliers.size()) < min_inliers) return {};
  return pose;
}

}  // namespace

std::optional<MovingPose> RefineMovingPose(const Camera& camera,
                                           const std::vector<PointMatch>& matches,
                                           const Rigid3& camera_from_world,
                                           int min_inliers,
                                           const MovingPoseOptions& options,
                                           double focal_scale) {
  const MovingState start{camera_from_world, {}, std::log(focal_scale)};
  const double max_error_px = options.max_error_px;
  if (options.focal_sigma_ratio > 0) {
    const MovingPoseProblem<kFocal + 1> problem(camera, matches, options);
    return RefineFrom(problem, start, min_inliers, max_error_px);
  }
  const MovingPoseProblem<kFocal> problem(camera, matches, options);
  return RefineFrom(problem, start, min_inliers, max_error_px);
}

}  // namespace nightmap
