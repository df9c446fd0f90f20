// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/picture_pose.h"

#include <utility>

#include "stages/camera/localize/rolling_shutter_pose.h"

namespace nightmap {
namespace {

// Expected distance that the camera moves from a picture's first row to its last.
constexpr double kReadoutShiftSigma_m = 0.002;
// A focal length that is off by half a step moves pixels by more than their noise.
constexpr double kStartErrorRatio = 2;

AbsolutePoseOptions PoseOptions(const LocalizeOptions& options,
                                int min_inliers,
                                std::uint64_t seed) {
  AbsolutePoseOptions pose_options;
  pose_options.solver = options.solver == "dlt6" ? MinimalSolver::kDlt6 : MinimalSolver::kP3p;
  pose_options.local_optimization = options.local_optimization;
  pose_options.refinement = options.refinement;
  pose_options.max_error_px = options.max_error_px;
  pose_options.min_inliers = min_inliers;
  pose_options.max_iterations = options.max_iterations;
  pose_options.seed = seed;
  return pose_options;
}

MovingPoseOptions MotionOptions(const LocalizeOptions& options, const PictureLens& lens) {
  return {.turn_sigma_rad = options.readout_turn_sigma_rad,
          .shift_sigma_m = kReadoutShiftSigma_m,
          .max_error_px = options.max_error_px,
          .focal_sigma_ratio = lens.focal_sigma_ratio};
}

std::optional<PicturePose> Refine(const PictureLens& lens,
                                  const std::vector<PointMatch>& matches,
                                  const PicturePose& from,
                                  int min_inliers,
                                  const MovingPoseOptions& options) {
  auto refined = RefineMovingPose(
      lens.camera, matches, from.pose.camera_from_world, min_inliers, options, from.camera);
  if (!refined) return {};
  return PicturePose{std::move(refined->pose), refined->camera};
}

// RANSAC with one lens, then least squares over pose and lens of a still camera.
std::optional<PicturePose> EstimateFrom(const Camera& camera,
                                        const LocalizeOptions& options,
                                        const PictureLens& lens,
                                        const std::vector<PointMatch>& matches,
                                        AbsolutePoseOptions pose_options) {
  constexpr double kStill = 1e-6;
  pose_options.max_error_px *= kStartErrorRatio;
  auto start = EstimateAbsolutePose(camera, matches, pose_options);
  if (!start) return {};
  MovingPoseOptions still = MotionOptions(options, lens);
  still.turn_sigma_rad = still.shift_sigma_m = kStill;
  return Refine(lens, matches, {*std::move(start), camera}, pose_options.min_inliers, still);
}

}  // namespace

std::vector<Camera> LensesToTry(const PictureLens& lens) {
  constexpr double kStep = 1.2;
  constexpr int kNumSteps = 5;
  std::vector<Camera> cameras = {lens.camera};
  if (lens.IsCalibrated()) return cameras;
  double scale = 1;
  for (int i = 0; i < kNumSteps; ++i) {
    scale *= kStep;
    cameras.push_back(lens.camera.WithFocalScale(scale));
    cameras.push_back(lens.camera.WithFocalScale(1 / scale));
  }
  return cameras;
}

std::optional<PicturePose> EstimatePicturePose(const LocalizeOptions& options,
                                               const PictureLens& lens,
                                               const std::vector<Camera>& starts,
                                               const std::vector<PointMatch>& matches,
                                               int min_inliers,
                                               std::uint64_t seed) {
  const AbsolutePoseOptions pose_options = PoseOptions(options, min_inliers, seed);
  std::optional<PicturePose> best;
  if (lens.IsCalibrated()) {
    auto pose = EstimateAbsolutePose(lens.camera, matches, pose_options);
    if (pose) best = PicturePose{*std::move(pose), lens.camera};
    return best;
  }
  for (const Camera& start : starts) {
    auto found = EstimateFrom(start, options, lens, matches, pose_options);
    if (!found || (best && found->pose.inliers.size() <= best->pose.inliers.size())) continue;
    best = std::move(found);
    if (2 * best->pose.inliers.size() > matches.size()) break;
  }
  return best;
}

std::optional<PicturePose> AllowMotion(const LocalizeOptions& options,
                                       const PictureLens& lens,
                                       const std::vector<PointMatch>& matches,
                                       const PicturePose& still) {
  if (!options.refinement || options.readout_turn_sigma_rad == 0) return {};
  return Refine(lens,
                matches,
                still,
                static_cast<int>(still.pose.inliers.size()),
                MotionOptions(options, lens));
}

}  // namespace nightmap
