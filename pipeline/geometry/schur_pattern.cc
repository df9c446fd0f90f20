// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/schur_pattern.h"

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

// For each pose the others that see one of its points, ascending. Only poses that may move.
std::vector<std::vector<int>> FindNeighbours(const BundleProblem& problem,
                                             const IndexGroups& of_pose,
                                             const IndexGroups& of_point,
                                             int num_threads) {
  const std::size_t num_poses = problem.camera_from_world.size();
  std::vector<std::vector<int>> neighbours(num_poses);
  ParallelFor(num_poses, num_threads, [&](std::size_t pose) {
    if (problem.is_fixed[pose]) return;
    std::vector<bool> is_seen(num_poses, false);
    is_seen[pose] = true;
    for (const int o : of_pose.Of(pose)) {
      const BundleObservation& seen = problem.observations[static_cast<std::size_t>(o)];
      for (const int other : of_point.Of(static_cast<std::size_t>(seen.point_idx))) {
        const auto other_pose = static_cast<std::size_t>(
            problem.observations[static_cast<std::size_t>(other)].pose_idx);
        if (is_seen[other_pose] || problem.is_fixed[other_pose]) continue;
        is_seen[other_pose] = true;
        neighbours[pose].push_back(static_cast<int>(other_pose));
      }
    }
  });
  return neighbours;
}

}  // namespace

BlockPattern MakeSchurPattern(const BundleProblem& problem,
                              const IndexGroups& of_pose,
                              const IndexGroups& of_point,
                              int num_calibrations,
                              int num_threads) {
  std::vector<bool> is_free;
  for (std::size_t pose = 0; pose < problem.camera_from_world.size(); ++pose) {
    is_free.push_back(!problem.is_fixed[pose] && !of_pose.Of(pose).empty());
  }
  return MakeBlockPattern(
      is_free, FindNeighbours(problem, of_pose, of_point, num_threads), 6, num_calibrations);
}

}  // namespace nightmap
