// SPDX-License-Identifier: Apache-2.0
// MinimizeSmall against Ceres on the same residuals: the pose of each keyframe from a disturbed
// start, the landmarks held.
#include <fmt/format.h>

#include "pipeline/geometry/levenberg_marquardt.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"
#include "tests/bench/libraries/landmark_problem.h"

namespace nightmap {
namespace {

std::vector<std::vector<BundleObservation>> ByPose(const BundleProblem& problem) {
  std::vector<std::vector<BundleObservation>> by_pose(problem.camera_from_world.size());
  for (const BundleObservation& seen : problem.observations) {
    by_pose[static_cast<std::size_t>(seen.pose_idx)].push_back(seen);
  }
  return by_pose;
}

NormalEquations<6> Equations(const BundleProblem& problem,
                             const std::vector<BundleObservation>& observations,
                             const Rigid3& pose) {
  NormalEquations<6> equations;
  for (const BundleObservation& seen : observations) {
    const auto i = static_cast<std::size_t>(seen.pose_idx);
    const Reprojection projected(
        problem.cameras[i],
        pose * problem.points_in_world[static_cast<std::size_t>(seen.point_idx)]);
    if (!projected.IsVisible()) continue;
    const PointMeasurement measured{seen.pixel,
                                    seen.depth_m,
                                    1 / seen.pixel_sigma_px,
                                    seen.depth_m > 0 ? 1 / seen.noise.Sigma_m(seen.depth_m) : 0};
    equations.AddRobust(projected.ByPose(projected.ByMovedPoint(measured)),
                        projected.Residual(measured));
  }
  return equations;
}

Rigid3 PoseByCeres(const BundleProblem& problem,
                   const std::vector<BundleObservation>& observations,
                   Rigid3 pose) {
  std::vector<Eigen::Vector3d> points = problem.points_in_world;
  ceres::Problem least_squares;
  auto* const loss = new ceres::CauchyLoss(2);
  for (const BundleObservation& seen : observations) {
    Eigen::Vector3d& point = points[static_cast<std::size_t>(seen.point_idx)];
    AddResidual(seen,
                problem.cameras[static_cast<std::size_t>(seen.pose_idx)],
                loss,
                pose,
                point,
                least_squares);
    least_squares.SetParameterBlockConstant(point.data());
  }
  least_squares.SetManifold(pose.rotation.coeffs().data(), new ceres::EigenQuaternionManifold);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &least_squares, &summary);
  return pose;
}

}  // namespace

void CompareSmallSolver(const MappedSite& site) {
  BundleProblem problem = MakeLandmarkProblem(site);
  const std::vector<Rigid3> settled = problem.camera_from_world;
  Disturb(&problem);
  problem.points_in_world = site.landmarks.positions_in_map;
  const auto observations = ByPose(problem);
  std::vector<Rigid3> ours, theirs;
  PrintComparison(
      {.ours = "`MinimizeSmall`",
       .other = "Ceres, dense QR",
       .input = fmt::format("{}: pose of a keyframe with {} points",
                            site.name,
                            problem.observations.size() / settled.size()),
       .run_ours =
           [&](int) {
             ours = problem.camera_from_world;
             for (std::size_t i = 0; i < ours.size(); ++i) {
               ours[i] = MinimizeSmall<6>(
                   {.max_steps = 20, .min_step = 1e-8},
                   ours[i],
                   [&](const Rigid3& pose) { return Equations(problem, observations[i], pose); },
                   PerturbLeft);
             }
           },
       .run_other =
           [&](int) {
             theirs = problem.camera_from_world;
             for (std::size_t i = 0; i < theirs.size(); ++i) {
               if (observations[i].empty()) continue;
               theirs[i] = PoseByCeres(problem, observations[i], theirs[i]);
             }
           },
       .difference =
           [&] {
             return fmt::format("at most {:.2g} mm, after moves of up to {:.0f} mm",
                                LargestShift_mm(ours, theirs),
                                LargestShift_mm(ours, problem.camera_from_world));
           },
       .num_items = static_cast<double>(settled.size())});
}

}  // namespace nightmap
