// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/rolling_shutter_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/geometry/levenberg_marquardt.h"

namespace nightmap {
namespace {

constexpr int kFocal = 12;   // index of the focal length among the unknowns
constexpr int kCentre = 13;  // of the principal point
constexpr int kNumCalibrated = 12;
constexpr int kNumWithLens = 15;

// A left perturbation of the pose (rotation, translation), then the motion (turn, shift), then the
// lens: logarithm of the focal length, and shift of the principal point.
struct MovingState {
  Rigid3 camera_from_world;
  ReadoutMotion motion;
  double log_focal_scale = 0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();

  template <int kSize>
  MovingState Stepped(const Eigen::Matrix<double, kSize, 1>& step) const {
    MovingState next{PerturbLeft(step.template head<6>(), camera_from_world),
                     {motion.turn_rad + step.template segment<3>(6),
                      motion.shift_m + step.template segment<3>(9)}};
    if constexpr (kSize == kNumWithLens) {
      next.log_focal_scale = log_focal_scale + step[kFocal];
      next.centre_px = centre_px + step.template segment<2>(kCentre);
    }
    return next;
  }
};

// kSize: kNumCalibrated or kNumWithLens.
template <int kSize>
class MovingPoseProblem {
 public:
  using Vector = Eigen::Matrix<double, kSize, 1>;
  static constexpr bool kHasLens = kSize == kNumWithLens;

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
    MovingPose result{{}, state.motion, camera_};
    if constexpr (kHasLens) result.camera = LensOf(state);
    AbsolutePose& pose = result.pose;
    pose.camera_from_world = state.camera_from_world;
    pose.inliers = Inliers(state, options_.max_error_px);
    const auto covariance = Equations(state, pose.inliers).Covariance();
    if (!covariance) return {};
    pose.covariance = covariance->template topLeftCorner<6, 6>();
    if constexpr (kHasLens) result.focal_sigma_ratio = std::sqrt((*covariance)(kFocal, kFocal));
    double sum = 0;
    for (const int i : pose.inliers) {
      sum += std::pow(Error_px(state, matches_[static_cast<std::size_t>(i)]), 2);
    }
    pose.rms_error_px = std::sqrt(sum / static_cast<double>(pose.inliers.size()));
    return result;
  }

 private:
  Camera LensOf(const MovingState& state) const {
    Camera lens = camera_.WithFocalScale(std::exp(state.log_focal_scale));
    lens.cx += state.centre_px.x();
    lens.cy += state.centre_px.y();
    return lens;
  }

  // The match as if the principal point were the camera's.
  static PointMeasurement Centred(const MovingState& state,
                                  const PointMatch& match,
                                  double weight) {
    PointMeasurement measured{.pixel = match.pixel, .per_pixel_sigma = weight};
    if constexpr (kHasLens) measured.pixel -= state.centre_px;
    return measured;
  }

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
    return seen.Residual(Centred(state, match, 1)).template head<2>().norm();
  }

  NormalEquations<kSize> Equations(const MovingState& state,
                                   const std::vector<int>& inliers) const {
    NormalEquations<kSize> equations;
    for (const int i : inliers) {
      const PointMatch& match = matches_[static_cast<std::size_t>(i)];
      const Reprojection seen = Reproject(state, match);
      if (!seen.IsVisible()) continue;
      const PointMeasurement measured = Centred(state, match, 1 / options_.pixel_sigma_px);
      const Eigen::Matrix3d by_p = seen.ByMovedPoint(measured);
      Eigen::Matrix<double, 2, kSize> jacobian;
      jacobian.template leftCols<6>() = seen.ByPose(seen.ByMiddlePoint(by_p)).topRows<2>();
      jacobian.template middleCols<6>(6) = seen.ByMotion(by_p).topRows<2>();
      if constexpr (kHasLens) {
        jacobian.col(kFocal) =
            std::exp(state.log_focal_scale) *
            seen.ByCalibration(measured, by_p, DepthCalibration::kHeld).col(0).template head<2>();
        jacobian.template rightCols<2>() = measured.per_pixel_sigma * Eigen::Matrix2d::Identity();
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
    if constexpr (kHasLens) {
      const double sigma_px = options_.centre_sigma_ratio * std::max(camera_.width, camera_.height);
      weights.template tail<2>().setConstant(1 / std::pow(sigma_px, 2));
      motion.template tail<2>() = state.centre_px;
    }
    equations->AddPrior(weights, motion);
    if constexpr (kHasLens) {
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
  // Unknowns hide inliers: a motion those at the first and last rows, a focal length those at the
  // borders.
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
                                           const Camera& start) {
  const double max_error_px = options.max_error_px;
  if (options.focal_sigma_ratio > 0) {
    const MovingPoseProblem<kNumWithLens> problem(camera, matches, options);
    const MovingState state{camera_from_world,
                            {},
                            std::log(start.fx / camera.fx),
                            {start.cx - camera.cx, start.cy - camera.cy}};
    return RefineFrom(problem, state, min_inliers, max_error_px);
  }
  const MovingPoseProblem<kNumCalibrated> problem(camera, matches, options);
  return RefineFrom(problem, {camera_from_world, {}}, min_inliers, max_error_px);
}

}  // namespace nightmap
