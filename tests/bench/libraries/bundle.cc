// SPDX-License-Identifier: Apache-2.0
// AdjustBundle against Ceres on the same residuals: all keyframes and landmarks, from a disturbed
// start.
#include <fmt/format.h>

#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"
#include "tests/bench/libraries/landmark_problem.h"

namespace nightmap {
namespace {

BundleSummary AdjustWithCeres(int num_threads, BundleProblem* data) {
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::EigenQuaternionManifold manifold;
  ceres::HuberLoss loss(BundleOptions{}.robust_scale);
  ceres::Problem problem(problem_options);
  for (const BundleObservation& seen : data->observations) {
    const auto pose = static_cast<std::size_t>(seen.pose_idx);
    AddResidual(seen,
                data->cameras[pose],
                &loss,
                data->camera_from_world[pose],
                data->points_in_world[static_cast<std::size_t>(seen.point_idx)],
                problem);
  }
  for (std::size_t i = 0; i < data->camera_from_world.size(); ++i) {
    Rigid3& pose = data->camera_from_world[i];
    if (!problem.HasParameterBlock(pose.translation.data())) continue;
    problem.SetManifold(pose.rotation.coeffs().data(), &manifold);
    if (!data->is_fixed[i]) continue;
    problem.SetParameterBlockConstant(pose.rotation.coeffs().data());
    problem.SetParameterBlockConstant(pose.translation.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = BundleOptions{}.max_iterations;
  options.num_threads = num_threads;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {.final_cost = summary.final_cost,
          .num_iterations = static_cast<int>(summary.iterations.size()) - 1};
}

}  // namespace

void CompareBundleAdjustment(const MappedSite& site) {
  BundleProblem start = MakeLandmarkProblem(site);
  Disturb(&start);
  std::vector<BundleProblem> ours(2, start);  // made by one thread, by two
  std::vector<BundleProblem> theirs(2, start);
  BundleSummary summary;
  BundleSummary of_ceres;
  PrintComparison(
      {.ours = "`AdjustBundle`",
       .other = "Ceres, sparse Schur",
       .input = fmt::format("{}: {} poses, {} points, {} observations",
                            site.name,
                            start.camera_from_world.size(),
                            start.points_in_world.size(),
                            start.observations.size()),
       .run_ours =
           [&](int num_threads) {
             BundleProblem& problem = ours[static_cast<std::size_t>(num_threads - 1)];
             problem = start;
             summary = AdjustBundle({.num_threads = num_threads}, &problem);
           },
       .run_other =
           [&](int num_threads) {
             BundleProblem& problem = theirs[static_cast<std::size_t>(num_threads - 1)];
             problem = start;
             of_ceres = AdjustWithCeres(num_threads, &problem);
           },
       .difference =
           [&] {
             return fmt::format(
                 "cost {:.6g} in {} steps, X {:.6g} in {}; poses at most {:.2g} mm apart; by one "
                 "thread and "
                 "by two {:.1g} mm, X {:.1g} mm",
                 summary.final_cost,
                 summary.num_iterations,
                 of_ceres.final_cost,
                 of_ceres.num_iterations,
                 LargestShift_mm(ours[0].camera_from_world, theirs[0].camera_from_world),
                 LargestShift_mm(ours[0].camera_from_world, ours[1].camera_from_world),
                 LargestShift_mm(theirs[0].camera_from_world, theirs[1].camera_from_world));
           }});
}

}  // namespace nightmap
