// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/rolling_shutter_pose.h"

#include <cmath>
#include <limits>

#include "pipeline/geometry/levenberg_marquardt.h"

namespace nightmap {
namespace {

using Vector12d = Eigen::Matrix<double, 12, 1>;

// A left perturbation of the pose (rotation, translation), then the motion (turn, shift).
struct State {
  Rigid3 camera_from_world;
  ReadoutMotion motion;

  State Stepped(const Vector12d& step) const {
    return {PerturbLeft(step.head<6>(), camera_from_world),
            {motion.turn_rad + step.segment<3>(6), motion.shift_m + step.tail<3>()}};
  }
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

  State Refine(const State& state, const std::vector<int>& inliers) const {
    return MinimizeSmall<12>(
        {.max_steps = 10, .min_gain = 1e-6},
        state,
        [&](const State& at) { return Equations(at, inliers); },
        [](const Vector12d& step, const State& at) { return at.Stepped(step); });
  }

  // Nothing when the inliers do not determine the pose.
  std::optional<AbsolutePose> Finish(const State& state) const {
    AbsolutePose pose;
    pose.camera_from_world = state.camera_from_world;
    pose.inliers = Inliers(state, options_.max_error_px);
    const auto covariance = Equations(state, pose.inliers).Covariance();
    if (!covariance) return {};
    pose.covariance = covariance->topLeftCorner<6, 6>();
    double sum = 0;
    for (const int i : pose.inliers) {
      sum += std::pow(Error_px(state, matches_[static_cast<std::size_t>(i)]), 2);
    }
    pose.rms_error_px = std::sqrt(sum / static_cast<double>(pose.inliers.size()));
    return pose;
  }

 private:
  Reprojection Reproject(const State& state, const PointMatch& match) const {
    static constexpr CameraCalibration kOneReadout{.readout_s = 1};
    return {camera_,
            state.camera_from_world * match.point_in_world,
            RowFraction(camera_, match.pixel),
            state.motion.PerReadout(),
            kOneReadout};
  }

  double Error_px(const State& state, const PointMatch& match) const {
    const Reprojection seen = Reproject(state, match);
    if (!seen.IsVisible()) return std::numeric_limits<double>::infinity();
    return seen.Residual({match.pixel}).head<2>().norm();
  }

  NormalEquations<12> Equations(const State& state, const std::vector<int>& inliers) const {
    NormalEquations<12> equations;
    for (const int i : inliers) {
      const PointMatch& match = matches_[static_cast<std::size_t>(i)];
      const Reprojection seen = Reproject(state, match);
      if (!seen.IsVisible()) continue;
      const PointMeasurement measured{.pixel = match.pixel,
                                      .per_pixel_sigma = 1 / options_.pixel_sigma_px};
      const Eigen::Matrix3d by_p = seen.ByMovedPoint(measured);
      Eigen::Matrix<double, 2, 12> jacobian;
      jacobian << seen.ByPose(seen.ByMiddlePoint(by_p)).topRows<2>(),
          seen.ByMotion(by_p).topRows<2>();
      equations.AddRobust<2>(jacobian, seen.Residual(measured).head<2>());
    }
    Vector12d weights = Vector12d::Zero();
    weights.segment<3>(6).setConstant(1 / std::pow(options_.turn_sigma_rad, 2));
    weights.tail<3>().setConstant(1 / std::pow(options_.shift_sigma_m, 2));
    Vector12d motion = Vector12d::Zero();
    motion.tail<6>() << state.motion.turn_rad, state.motion.shift_m;
    equations.AddPrior(weights, motion);
    return equations;
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
  // A motion that is not known yet hides inliers at the first and last rows.
  constexpr double kWider = 1.5;
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
